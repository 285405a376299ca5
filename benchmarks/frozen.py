"""Hold what the program computes against references kept in benchmarks/frozen.json.

make frozen                                  all data sets
… benchmarks/frozen.py NAME…                 some of them
… benchmarks/frozen.py --make [NAME…]        write the references
… benchmarks/frozen.py --accept REASON …     keep today's deviations as exceptions, for this reason

Each data set goes through the command line with fixed seeds. One line is printed for each
deviation beyond `tolerated`; any that is not among the exceptions of the file makes it fail.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import os
import re
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
HERE = Path(__file__).resolve().parent
KEPT = HERE / "frozen.json"
SHARED = HERE.parents[1] / "shared" / "data"
PERIODS = (30, 100, 300)
Outcome = dict[str, Any]


@dataclass(frozen=True, slots=True)
class DataSet:
    """Records, and what is asked of them.

    `source` is a folder of the shared data (of which `every` n-th event is taken), the options
    of `synth`, or nothing for the data of the demo. `add` are effects of a child; the last model
    made answers for hazard, zones and the report. `methods` are the paper's, for more models.
    """

    source: str
    calibrate: str = ""
    add: str = ""
    methods: tuple[str, ...] = ()
    every: int = 1
    diagnose: bool = True
    hazard: str = " ".join(f"--return-period {T}" for T in PERIODS)
    zones: bool = True


def synth(
    effect: str, events: int, paths: int, seed: int, more: str = "", **others: Any
) -> DataSet:
    """A synthetic data set with an effect, which is what is added."""
    source = f"synth --effect {effect} --events {events} --paths {paths} --seed {seed} {more}"
    return DataSet(source, **({"add": effect} | others))


NO_PROFILE: dict[str, Any] = {"hazard": "", "zones": False}
ONE_VOLUME: dict[str, Any] = {"hazard": "--volume 75000", "zones": False}
CONSTANT, POWER, DRAG = "--law constant", "--law power", "turbulent-drag"
SETS = {
    "twin": DataSet("", add="path-effect", methods=("metropolis", "gibbs")),
    "demo": synth("snow-type", 120, 6, 0, "--strength 2"),
    "tutorial": synth("forest-drag", 100, 6, 3, "--strength 2"),
    "null": DataSet("synth --events 80 --paths 5 --seed 11", add="season"),
    "forest-drag": synth("forest-drag", 90, 5, 12, calibrate="--with path-effect"),
    "turbulent-drag": synth(DRAG, 60, 5, 13, "--speeds 0.2"),
    "snow-type": synth("snow-type", 90, 5, 14, calibrate="--tails student"),
    "volume-law": synth("volume-law", 120, 5, 15, "--strength 2", calibrate="--scatter volume"),
    "path-effect": synth("path-effect", 90, 7, 16),
    "observation-limit": synth("observation-limit", 90, 5, 17),
    "iseesnow-coulomb": DataSet("iseesnow-coulomb", CONSTANT, DRAG, **ONE_VOLUME),
    "iseesnow-voellmy": DataSet("iseesnow-voellmy", CONSTANT, DRAG, diagnose=False, **ONE_VOLUME),
    "rock-avalanches-canada": DataSet(
        "rock-avalanches-canada", POWER, "covariate:confinement", **NO_PROFILE
    ),
    "submarine-slides": DataSet("submarine-slides", POWER, every=6, diagnose=False, **NO_PROFILE),
    "avanodes": DataSet("avanodes", CONSTANT, **ONE_VOLUME),
}
QUICK = ("null", "rock-avalanches-canada", "avanodes")
"""Those that the tests run."""


def outcome(data: DataSet) -> Outcome:
    """What the program says of a data set, by a name whose first word says what it is."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = command_line(folder / "frozen.db")
        run("init")
        with records(data, folder, run) as source:
            run(f"import {source}")
        base = run(f"calibrate base {data.calibrate}")
        found = {"n events": base["n_events"], "fingerprint": base["data_fingerprint"]}
        found |= posterior("base", base) | scores("base", run("compare base"))
        for method in data.methods:
            found |= posterior(method, run(f"calibrate {method} --method {method}"))
        if data.diagnose:
            found |= verdict(run("diagnose base"))
        last = "base"
        if data.add:
            last = "child"
            found |= posterior(last, run(f"add base {data.add} --as child"))
            found |= scores(last, run("compare child"))
        if data.hazard:
            found |= designs(run(f"hazard {last} {data.hazard}"))
        if data.zones:
            found |= zones(run(f"zones {last} --no-drag"))
        page = folder / "report.html"
        found |= report(run(f"report {last} -o {page}"), page, found)
        return found


def command_line(database: Path) -> Callable[[str], Any]:
    """A function that runs a command on `database` and returns the document it prints."""
    from avahazard.cli.main import app  # noqa: PLC0415 (after the threads are set)

    def run(command: str) -> Any:
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = app(["--db", str(database), "--json", *command.split()], standalone_mode=False)
        if status:
            raise RuntimeError(f"{command}: {err.getvalue()}")
        return json.loads(out.getvalue())

    return run


@contextmanager
def records(data: DataSet, folder: Path, run: Callable[[str], Any]) -> Iterator[str]:
    """The sources of a data set, made in `folder` where they are synthetic."""
    if not data.source:
        with as_file(files("avahazard.data")) as made:
            yield " ".join(str(made / f"{file}.csv") for file in ("paths", "profiles", "events"))
    elif data.source.startswith("synth"):
        run(f"synth {folder / 'records'} {data.source.removeprefix('synth')}")
        yield str(folder / "records")
    elif data.every == 1:
        yield str(SHARED / data.source)
    else:
        with (SHARED / data.source / "events.csv").open(encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file)
        with (folder / "events.csv").open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, *rows[:: data.every]])
        yield str(folder / "events.csv")


def posterior(model: str, found: Outcome) -> Outcome:
    """Mean and standard deviation of each parameter."""
    return {f"posterior {model} {k}": [v["mean"], v["sd"]] for k, v in found["parameters"].items()}


def scores(model: str, found: Outcome) -> Outcome:
    """In-sample and held-out scores of runouts and speeds, and what explains the error."""
    kept: Outcome = {}
    for where, part in (("in-sample", found["scores"]), ("held-out", found["held_out"])):
        kept[f"elpd {model} {where}"] = part["elpd_loo"]
        for what in ("runout", "runout_x", "speed"):
            of = part.get(what) or {}
            for key in sorted(set(of) - {"n", "pit_histogram"}):
                unit = "_m_s" if what == "speed" else "_m"
                allowed = 0.03 * max(abs(of[key]), of[f"rmse{unit}"] if "bias" in key else 0.0)
                if "coverage" in key:
                    allowed = max(0.025, 1.0 / of["n"])
                kept[f"score {model} {where} {what} {key}"] = [of[key], allowed]
    for part in found["budget"]:
        if part["source"] != "unexplained":  # what is left of all others
            kept[f"score {model} budget {part['source']}"] = [part["rms_m"], 0.03 * part["rms_m"]]
    return kept


def verdict(found: Outcome) -> Outcome:
    """The verdict, what is named and what that gains, groups that differ."""
    kept: Outcome = {key: found[key] for key in ("verdict", "missing")}
    kept["pairs"] = [pair["effects"] for pair in found["pairs"]]
    for one in found["candidates"]:
        if one["effect"] in found["missing"]:
            for key in ("gain", "evidence_gain", "held_out_gain"):
                kept[f"gain {one['effect']} {key}"] = one[key]
    return kept | {f"gain {x['effect']} groups": x["gain"] for x in found["groups"]}


def designs(found: list[Outcome]) -> Outcome:
    """5, 50 and 95 % of the design runouts, or of the runouts of a volume."""
    kept: Outcome = {}
    for row in found:
        period, of = row["return_period_years"], row.get("design") or row
        asked = f"{row['volume_m3']:.0f} m3" if period is None else f"{period:g} years"
        for where in ("runout_x_m", "runout_elevation_m"):
            name = f"design {row['path_id']} {asked} {where}"
            kept[name] = [of[where][q] for q in ("q05", "q50", "q95")]
    return kept


def zones(found: list[Outcome]) -> Outcome:
    """Where each zone ends (5, 50 and 95 %), and the highest median speed of a return period."""
    kept: Outcome = {}
    for path in found:
        for zone in path["zones"]:
            ends = [zone["to_x_q05_m"], zone["to_x_m"], zone["to_x_q95_m"]]
            kept[f"zone {path['path_id']} {zone['zone']}"] = ends
        here = [x for place in path["places"] for x in place["by_return_period"]]
        for period in sorted({x["return_period_years"] for x in here}):
            fastest = max(x["speed_m_s"]["q50"] for x in here if x["return_period_years"] == period)
            kept[f"score {path['path_id']} speed of {period:g} years"] = [fastest, 0.03 * fastest]
    return kept


def report(found: Outcome, page: Path, known: Outcome) -> Outcome:
    """What the report holds: counts, and how many design medians its text states."""
    html = page.read_text(encoding="utf-8")
    text = re.sub(r"<[^>]*>|&#160;|&nbsp;|\s", "", html)
    medians = [
        x[1] for key, x in known.items() if key.startswith("design") and key.endswith("_x_m")
    ]
    return {
        "report paths": found["n_paths"],
        "report events": found["n_events"],
        "report lacking": len(found["lacking"]),
        "report tables": html.count("<table"),
        "report medians stated": sum(f"{x:.0f}m" in text for x in medians if x is not None),
    }


def tolerated(name: str, before: Any, now: Any) -> bool:
    """Whether a value is the reference's, within what its kind allows.

    Posterior means within 0.1 standard deviations, and these within 10 %; design runouts and zones
    within 5 m or 0.1 of their 90 % interval; log densities and gains within 1 nat; scores within
    what stands beside them: 3 % (of a bias: of the root mean square error), shares of records
    0.025 or one record. All else is equal.
    """
    if before is None or now is None:
        return before is now
    kind = name.split(maxsplit=1)[0]
    if kind == "posterior":
        return near(before[0], now[0], 0.1 * before[1]) and near(before[1], now[1], 0.1 * before[1])
    if kind in ("design", "zone"):
        width = 0.0 if None in (before[0], before[2]) else abs(before[2] - before[0])
        return all(near(x, y, max(5.0, 0.1 * width)) for x, y in zip(before, now, strict=True))
    if kind == "score":
        return near(before[0], now[0], before[1])
    return near(before, now, 1.0) if kind in ("elpd", "gain") else bool(before == now)


def near(before: float | None, now: float | None, limit: float) -> bool:
    """Whether both are absent, or within `limit` of each other."""
    if before is None or now is None:
        return before is now
    return abs(now - before) <= limit


def deviations(before: Outcome, now: Outcome) -> dict[str, list[Any]]:
    """What is not tolerated, by name: the reference, and today's; null where there is none."""
    pairs = {k: [before.get(k), now.get(k)] for k in dict.fromkeys((*before, *now))}
    return {name: pair for name, pair in pairs.items() if not tolerated(name, *pair)}


def references(kept: Outcome, name: str) -> Outcome:
    """The references of a data set, with the values of accepted exceptions."""
    accepted = kept["exceptions"].get(name, {})
    return kept["references"][name] | {key: value for key, (value, _) in accepted.items()}


def load() -> Outcome:
    """What is kept: `references` and `exceptions`, by data set."""
    if not KEPT.exists():
        return {"exceptions": {}, "references": {}}
    kept: Outcome = json.loads(KEPT.read_text(encoding="utf-8"))
    return kept


def save(kept: Outcome) -> None:
    """Write what is kept, a line for each value."""
    lines = json.dumps(kept, indent=0, ensure_ascii=False)
    short = re.sub(r"\[[^\[\]{}]*\]", lambda found: found[0].replace("\n", " "), lines)
    KEPT.write_text(short + "\n", encoding="utf-8")


def rounded(value: Any) -> Any:
    """Numbers to six digits."""
    if isinstance(value, list):
        return [rounded(x) for x in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def main() -> int:
    """Run the data sets; make the references, or print what deviates. Returns the exit status."""
    parser = argparse.ArgumentParser(description="Results held against references.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(SETS)}")
    parser.add_argument("--make", action="store_true", help="write the references")
    parser.add_argument("--accept", metavar="REASON", help="keep deviations as exceptions")
    given = parser.parse_args()
    kept, n_refused, began = load(), 0, time.process_time()
    for name in given.names or SETS:
        start = time.process_time()
        try:
            now = {key: rounded(value) for key, value in outcome(SETS[name]).items()}
        except Exception as error:  # the others are run all the same
            print(f"{name}: {error!r}", flush=True)
            n_refused += 1
            continue
        if given.make:
            kept["references"][name] = now
            kept["exceptions"].pop(name, None)
        found = deviations(references(kept, name), now)
        for key, (before, value) in found.items():
            print(f"{name}: {key}: {before} is now {value}")
        if given.accept:
            accepted = {key: [value, given.accept] for key, (_, value) in found.items()}
            kept["exceptions"].setdefault(name, {}).update(accepted)
            found = {}
        if given.make or given.accept:
            save(kept)
        n_refused += len(found)
        print(
            f"{name}: {len(now)} values, {len(found)} deviate, "
            f"{len(kept['exceptions'].get(name, {}))} exceptions, "
            f"{time.process_time() - start:.0f} CPU-s",
            flush=True,
        )
    print(f"{time.process_time() - began:.0f} CPU-s in all; {n_refused} deviations not accepted")
    return int(n_refused > 0)


if __name__ == "__main__":
    sys.exit(main())
