"""The loop as a user goes through it: import, calibrate, then what each command says next.

Commands run as on the command line, with `--json`; the truth comes in when the loop is over.
"""

from __future__ import annotations

import json
import os
import shlex
import time
from collections.abc import Mapping, Sequence
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from typer.testing import CliRunner

from avahazard.cli.main import app
from benchmarks.study import Line
from benchmarks.worlds import beyond, catalogue
from benchmarks.worlds.knowing import knowing

ROUNDS = 3
STEPS = ("compare", "diagnose", "add")
"""The steps that the loop takes; another one (`hazard`, `measure`, …) ends it."""


def judge(name: str) -> Line:
    """The result on the dataset `ARM #SEED`.

    `rounds` are verdict, names and CPU-s of each diagnosis; `crps` (m along the path) is that of
    the base model, of each model added, and of the one that the last step names if that is another;
    `knows` that of one who knows the form, `gain` (nats) what that one gains; `inside` the share of
    a found force's band that holds the true force, None where there is no band.
    """
    arm, _, seed = name.rpartition(" #")
    with TemporaryDirectory() as folder, chdir(folder):
        of = catalogue if arm in catalogue.ARMS else beyond
        truth = of.make(arm, int(seed), Path())
        line: Line = {"right": truth["right"], "neutral": truth["neutral"]}
        diagnoses = go_round(truth.get("without", ()), line)
        if not truth["right"]:
            return line
        if of is beyond:
            known = knowing(Path())
            # Beside a force that was added before, a shape is that of what is left.
            naming = (d for d in diagnoses if {*d["missing"]} & {*truth["right"]})
            band = next((leading_band(d, truth["right"]) for d in naming), None)
            inside = None if band is None else share_inside(arm, int(seed), band)
            return line | {"gain": known["gain"], "knows": known["crps"], "inside": inside}
        (key,) = truth["right"]
        first = diagnoses[0] if diagnoses else {"candidates": [], "groups": []}
        gains = {c["effect"]: c["gain"] for c in (*first["groups"], *first["candidates"])}
        line["gain"] = round(gains.get(key, 0.0), 2)
        try:
            command("add", "base", key, "--as", "knows")
            line["knows"] = held_out("knows")
        except CommandError:
            line["knows"] = None  # the data cannot say what the effect needs
        return line


class CommandError(Exception):
    """A command ended with an error, which is its message."""


def command(*words: str) -> Any:
    """The document that a command prints, in the database of this folder.

    Raises `CommandError` where it ends with an error.
    """
    done = CliRunner().invoke(app, ["--json", *words], prog_name="avahazard")
    if done.exit_code:
        raise CommandError(f"{shlex.join(words)}: {done.stderr.strip() or done.exception!r}")
    return json.loads(done.stdout)


def go_round(without: Sequence[str], line: Line) -> list[dict[str, Any]]:
    """Go through the loop, at most `ROUNDS` diagnoses; tell it in `line`. Returns the diagnoses."""
    forms = ("paths.csv", "profiles.csv", "events.csv", "velocities.csv")
    line |= {"crps": [], "rounds": []}
    diagnoses: list[dict[str, Any]] = []
    model = ""
    words = ["calibrate", "base", *(word for key in without for word in ("--without", key))]
    try:
        command("init")
        command("import", *(form for form in forms if os.path.exists(form)))
        while words[0] in ("calibrate", *STEPS):
            # One that writes the law of a diagnosis is that diagnosis again.
            round_ = words[0] == "diagnose" and "--write-effect" not in words
            if round_ and len(diagnoses) == ROUNDS:
                break
            began = time.process_time()
            found = command(*words)
            if round_:
                seconds = round(time.process_time() - began, 1)
                line["rounds"].append([found["verdict"], found["missing"], seconds])
                diagnoses.append(found)
            elif words[0] not in ("compare", "diagnose"):
                model, files = found["model"], _effect_files(words)
                line["crps"].append(held_out(model, files))
            step = found.get("next") or ""
            words = shlex.split(step)[1:] if step.startswith("avahazard ") else ["measure"]
        if words[0] == "hazard" and words[1] != model:
            line["crps"].append(held_out(words[1], _effect_files(words)))
    except CommandError as error:
        line["error"] = str(error)
    return diagnoses


def _effect_files(words: Sequence[str]) -> list[str]:
    """The options of a command that name effect files."""
    at = [k for k, word in enumerate(words) if word == "--effect-file"]
    return [word for k in at for word in words[k : k + 2]]


def held_out(model: str, files: Sequence[str] = ()) -> float:
    """Mean CRPS (m along the path) of the held-out events."""
    scores = command("predict", model, "held_out/events.csv", *files)["scores"]
    return round(float(scores["runout_x"]["crps_m"]), 2)


def leading_band(found: Mapping[str, Any], right: Sequence[str]) -> dict[str, Any] | None:
    """The shape of the first candidate, where it is a force of the right state."""
    first = next(iter(found["candidates"]), {})
    return first.get("shape") if first.get("effect") in right else None


def share_inside(arm: str, seed: int, shape: Mapping[str, Any]) -> float | None:
    """Share of the places of a band between which the true force lies; None where there is none.

    By speed it is a force per mass (m/s2), by slope (degrees) one per load, about its mean.
    """
    force = beyond.drawn(arm, seed)[0].force
    x, low, high = (np.array(shape[key]) for key in ("x", "q05", "q95"))
    if force is None or shape["of"] not in ("speed", "slope"):
        return None
    load = np.full(1, beyond.G)
    if shape["of"] == "speed":
        true = force(beyond.State(0, 0.5, 2000.0, 0.5, 0.0, x, np.full(len(x), beyond.G)))
    else:
        slopes = np.tan(np.radians(x))
        states = [beyond.State(0, 0.5, 2000.0, s, 0.0, np.full(1, 20.0), load) for s in slopes]
        true = np.array([float(force(state)[0]) for state in states]) / beyond.G
        true -= np.mean(true)
    return round(float(np.mean((low <= true) & (true <= high))), 3)
