"""Speeds measured where the diagnosis advises it, or by a fixed plan: what one avalanche gains.

On a part of a dataset's events `diagnose` advises a path and a place that distinguish two of its
explanations, of which one is right.  The speeds of some recorded avalanches are then added: there,
or by the fixed plan half-way from release to stop on any path; the evidence for the right one over
the other grows.
"""

from __future__ import annotations

import csv
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from avahazard.criticism.diagnosis import nuisances
from avahazard.criticism.diagnosis.refits import refit_with
from avahazard.workflow.stored import load_stored
from benchmarks.study import Line, table
from benchmarks.worlds import beyond
from benchmarks.worlds.loop import command
from benchmarks.worlds.tables import same

N_RECORDS, N_SPEEDS = 80, 6
SIGMA_M_S = 1.5
ARMS = ("force by u", "force by u^1.5", "force above a speed", "force by slope", "force in a band")


def judge(name: str) -> Line:
    """What speeds in one avalanche gain on `ARM #SEED` (nats): `expected`, `advised`, `fixed`.

    All None where no speed is advised that distinguishes the right effect from another.
    """
    arm, _, seed = name.rpartition(" #")
    line: Line = {"expected": None, "advised": None, "fixed": None}
    with TemporaryDirectory() as folder, chdir(folder):
        truth = beyond.make(arm, int(seed), Path())
        events = [*_read("events.csv"), *_read("held_out/events.csv")]
        order = np.random.default_rng(int(seed)).permutation(len(events))
        stopped = [events[k] for k in order if not int(events[k]["left_profile"])]
        records = stopped[:N_RECORDS]
        stored(records, [])
        found = command("diagnose", "base")
        right = {same(key) for key in truth["right"]}
        for advice in found["measure_next"]:
            keys = advice["between"]
            of_right = [same(key) in right for key in keys]
            if advice["x_m"] is not None and (of_right == [True] or sum(of_right) == 1):
                break
        else:
            return line
        keys = sorted(keys, key=lambda key: same(key) not in right)
        truths = Truth(arm, int(seed), truth)
        there = [e for e in records if e["path_id"] == advice["path_id"]]
        before = gap(keys)
        line |= {"between": keys, "place": [advice["path_id"], advice["x_m"]]}
        n_advised = int(advice["measurement"].partition(" avalanche")[0].split()[-1])
        line["expected"] = advice["expected_gain"] / n_advised
        plans = {
            "advised": [truths.measured(e, advice["x_m"]) for e in there],
            "fixed": [truths.measured(e, None) for e in records],
        }
        for plan, tried in plans.items():
            speeds = [speed for speed in tried if speed is not None][:N_SPEEDS]
            stored(records, speeds)
            line[plan] = (gap(keys) - before) / len(speeds)
    return line


def gap(keys: list[str]) -> float:
    """Evidence (nats) of the first effect over the second, or over none, in the database here."""
    found, _ = load_stored("avahazard.db", "base", own=())
    given = found.observations, found.specification, found.facts, ()
    base, *_ = nuisances.with_nuisances_granted(nuisances.with_tails_granted(*given))
    first, other = [*(refit_with(base, key) for key in keys), base][:2]
    return float(first.evidence - other.evidence)


def stored(events: list[dict[str, Any]], speeds: list[dict[str, Any]]) -> None:
    """The base model of these events and speeds, in a new database here."""
    Path("avahazard.db").unlink(missing_ok=True)
    _write("events.csv", events)
    files = ["paths.csv", "profiles.csv", "events.csv"]
    if speeds:
        _write("velocities.csv", speeds)
        files.append("velocities.csv")
    command("init")
    command("import", *files)
    command("calibrate", "base")


class Truth:
    """The true speeds of a dataset's avalanches."""

    def __init__(self, arm: str, seed: int, truth: dict[str, Any]) -> None:
        self.world, *_ = beyond.drawn(arm, seed)
        self.mu = np.array(truth["events"]["mu"])
        self.number = {key: k for k, key in enumerate(truth["events"]["event_id"])}
        self.stop = truth["events"]["stop_x_m"]
        self.rng = np.random.default_rng([seed, 1])

    def measured(self, event: dict[str, Any], x: float | None) -> dict[str, Any] | None:
        """A speed of an event at x, half-way for None; None where it does not come by."""
        row = self.number[event["event_id"]]
        path = self.world.path[row]
        terrain = self.world.terrains[path]
        release, stop = float(terrain.x[self.world.release[row]]), self.stop[row]
        x = 0.5 * (release + stop) if x is None else x
        if not release < x < stop:
            return None
        _, squares = beyond.run_all(self.world, np.array([row]), self.mu[[row]])
        nodes = terrain.x[::2][: len(squares[path])]
        true = float(np.sqrt(np.interp(x, nodes, squares[path][:, 0])))
        speed = max(true + SIGMA_M_S * float(self.rng.normal()), 0.0)
        return {
            "event_id": event["event_id"],
            "x_m": round(x, 1),
            "speed_m_s": round(speed, 2),
            "speed_sigma_m_s": SIGMA_M_S,
        }


def parts(found: list[Line]) -> dict[str, str]:
    """The table of the page."""
    lines = [line for line in found if line["expected"] is not None]
    columns = ("expected", "advised", "fixed")
    rows = [
        (line["name"], " and ".join(line["between"]), *(f"{line[c]:.1f}" for c in columns))
        for line in lines
    ]
    means = [f"{np.mean([line[c] for line in lines]):.1f}" for c in columns]
    head = ("dataset", "explanations", "expected, nats", "as advised", "fixed plan")
    return {"measuring": table(head, [*rows, (f"mean of {len(lines)}", "", *means)])}


def _read(file: str) -> list[dict[str, Any]]:
    with open(file, newline="", encoding="utf-8") as given:
        return list(csv.DictReader(given))


def _write(file: str, rows: list[dict[str, Any]]) -> None:
    with open(file, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
