"""The loop as a user goes through it: calibrate, diagnose, do what the diagnosis says next.

Only results are read that `--json` prints too; the truth comes in when the loop is over.
"""

from __future__ import annotations

import shlex
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import avahazard as av
from avahazard.api import Model, Region
from avahazard.records.errors import AvahazardError
from benchmarks.study import Line
from benchmarks.worlds import beyond, catalogue
from benchmarks.worlds.knowing import knowing

ROUNDS = 3


def judge(name: str) -> Line:
    """What came out on the dataset `ARM #SEED`.

    `rounds` are verdict, names and CPU-s of each diagnosis; `crps` (m along the path) is that of
    the base model and after each step, `knows` that of one who knows the form, `gain` (nats) what
    that one gains; `inside` the share of a found force's band that holds the true force, None where
    there is no band.
    """
    arm, _, seed = name.rpartition(" #")
    with TemporaryDirectory() as temporary:
        folder = Path(temporary)
        of = catalogue if arm in catalogue.ARMS else beyond
        truth = of.make(arm, int(seed), folder)
        line: Line = {"right": truth["right"], "neutral": truth["neutral"]}
        region, diagnoses = go_round(folder, truth.get("without", ()), line)
        if not truth["right"]:
            return line
        if of is beyond:
            known = knowing(folder)
            band = next((b for d in diagnoses if (b := leading_band(d, truth["right"]))), None)
            inside = None if band is None else share_inside(arm, int(seed), band)
            return line | {"gain": known["gain"], "knows": known["crps"], "inside": inside}
        (key,) = truth["right"]
        first = diagnoses[0] if diagnoses else {"candidates": [], "groups": []}
        gains = {c["effect"]: c["gain"] for c in (*first["groups"], *first["candidates"])}
        line["gain"] = round(gains.get(key, 0.0), 2)
        try:
            line["knows"] = held_out(region.model("base").add(key, name="knows"), folder)
        except AvahazardError:
            line["knows"] = None  # the data cannot say what the effect needs
        return line


def go_round(
    folder: Path, without: Sequence[str], line: Line
) -> tuple[Region, list[dict[str, Any]]]:
    """Diagnose and add until nothing is to be added, at most `ROUNDS` times; tell it in `line`.

    Returns the region and the diagnoses.
    """
    files = [folder / f"{form}.csv" for form in ("paths", "profiles", "events", "velocities")]
    region = av.Region.from_files(*(file for file in files if file.exists()))
    model = region.calibrate("base", without=without)
    line |= {"crps": [held_out(model, folder)], "rounds": []}
    diagnoses = []
    for k in range(ROUNDS):
        try:
            began = time.process_time()
            found = model.diagnose().to_dict()
            seconds = round(time.process_time() - began, 1)
            line["rounds"].append([found["verdict"], found["missing"], seconds])
            diagnoses.append(found)
            effects, own = to_add(found)
            if not effects:
                break
            model = model.add(*effects, name=f"round-{k + 1}", effect_files=own)
            line["crps"].append(held_out(model, folder))
        except Exception as error:  # whatever it is, it counts
            line["error"] = f"round {k + 1}: {type(error).__name__}: {error}"
            break
    return region, diagnoses


def to_add(found: Mapping[str, Any]) -> tuple[list[str], list[Path]]:
    """Effects that a diagnosis says to add, and the files of those that it wrote."""
    words = shlex.split(found["next"]) if "next" in found else printed(found)
    if words[:1] == ["avahazard"]:
        words = words[1:]
    if words[:1] != ["add"]:
        return [], []
    at = words.index("--as")
    pairs = zip(words[at:], words[at + 1 :], strict=False)
    return words[2:at], [Path(word) for flag, word in pairs if flag == "--effect-file"]


def printed(found: Mapping[str, Any]) -> list[str]:
    """The command that the terminal prints below a diagnosis."""
    effects = found["missing"] if found["verdict"] == "missing-effect" else []
    if found["pairs"]:
        effects = found["pairs"][-1]["effects"]
    return ["add", found["model"], *effects, "--as", "NEW"]


def held_out(model: Model, folder: Path) -> float:
    """Mean CRPS (m along the path) of the events held out."""
    scores = model.predict(folder / "held_out" / "events.csv").scores
    assert scores is not None
    assert scores.runout_x is not None
    return round(scores.runout_x.crps_m, 2)


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
