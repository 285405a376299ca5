"""A Coulomb block and a turbulent drag against speeds measured inside four avalanches.

Writes docs/avanodes.md. The records are not part of the project: their folder is the argument, by
default ../shared/data/avanodes. Run from the root of the checkout: make avanodes
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.physics.constants import GRAVITY
from avahazard.results.calibration import Calibration
from avahazard.workflow.add import add
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.import_files import import_files

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "avanodes.md"
RECORDS = ROOT.parent / "shared" / "data" / "avanodes"

TITLE = """# Measured speeds: a Coulomb block, and with drag

Four sensors were carried along inside small avalanches (Nordkette, Innsbruck, 2021 and 2022;
Neuhauser and others 2023) and tell the speed every 10 m. A Coulomb block is set against these
speeds; then turbulent drag is added. Written by `make avanodes`, as it came out. The records
themselves may not be passed on and are not part of the project.
"""

LIMITS = """A sensor is a particle inside the flow, not its front, and these came to rest on steep
ground, where a block would slide on. Four tracks on one slope are few, and their records have no
volumes. So this is a test of the comparison more than of the physics.

All four came to rest where no one friction stops a block: F jumps there. What is predicted is the
speed under the mean friction of the way to the stop, and an error that friction makes which goes up
and down along the track by `track_sigma` ([the likelihood](theory/likelihood.md)): it adds up from
the release on, and is nothing again at the stop. With an error of speed that is as large everywhere
and a block that slides past the stop, as it was before, the 90 % intervals of held-out speeds
held 62 %. That friction is alike over 100 m matters little here: for lengths of 20 to 1000 m the
likelihood at its best differs by 2 nats; were it alike over no length, it would be 19 less (on the
points of the profiles, without the load of curvature).
"""


FORCE = """\
g sinθ - u du/dξ along the tracks, over stretches of 20 m or more (Ancey and Meunier 2004).
For Coulomb friction it is the same at all speeds (times cosθ); with drag it rises as u². Where it
equals g sinθ the speed was steady, which friction alone can hold on one slope only.
"""
WITNESS = """\
An effect on the motion is named only if the measured force asks for it too, along all tracks and
with its error; where it denies the leader, the verdict is `unexplained`, with the axis.
"""


def run(records: Path) -> str:
    """Calibrate without and with drag on `records`, and return the page."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "avanodes.db")
        init_database(database)
        import_files(database, [records])
        models = {"Coulomb": calibrate(database, "coulomb", law="constant")}
        found = {"Coulomb": compare(database, "coulomb").to_dict()}
        verdict = diagnose_model(database, "coulomb").to_dict()
        models["with drag"] = add(database, "coulomb", ["turbulent-drag"], "drag")
        found["with drag"] = compare(database, "drag").to_dict()
    return "\n".join(
        (
            TITLE,
            "## Speeds and runouts, all four and each held out\n",
            _scores(found),
            _in_words(found),
            LIMITS,
            "## Speeds by place along the path\n",
            "The friction of each event is the one that its own stop asks for, so the misfit is",
            "the motion's. Bias is predicted less measured.\n",
            _places(found),
            "## The force that the speeds tell of\n",
            FORCE,
            _force(found["Coulomb"]["measured_force"]),
            "## What the diagnosis says\n",
            _verdict(verdict),
            "## Parameters\n",
            _parameters(models),
        )
    )


def _scores(found: dict[str, dict[str, Any]]) -> str:
    lines = [
        "| model | speeds | RMSE m/s | bias m/s | CRPS m/s | within 50 % | within 90 % "
        "| runout RMSE m | runout CRPS m |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for part, words in (("scores", "calibrated on all"), ("held_out", "path held out")):
        for model, document in found.items():
            speed, runout = document[part]["speed"], document[part]["runout"]
            lines.append(
                f"| {model} | {words} | {speed['rmse_m_s']:.1f} | {speed['bias_m_s']:+.1f} "
                f"| {speed['crps_m_s']:.1f} | {speed['coverage_50']:.0%} "
                f"| {speed['coverage_90']:.0%} | {runout['rmse_m']:.0f} | {runout['crps_m']:.0f} |"
            )
    floor = found["Coulomb"]["scores"]["speed"]["noise_floor_m_s"]
    return "\n".join([*lines, "", f"The errors of the speeds themselves leave {floor:.1f} m/s.\n"])


def _in_words(found: dict[str, dict[str, Any]]) -> str:
    """Better or worse, number by number, on the speeds of held-out paths."""
    before, after = (found[m]["held_out"] for m in ("Coulomb", "with drag"))

    def change(what: str, part: str, key: str, unit: str, digits: int) -> str:
        a, b = before[part][key], after[part][key]
        old, new = f"{a:.{digits}f}", f"{b:.{digits}f}"
        if old == new:
            return f"- {what} stays at {new} {unit}."
        return f"- {what} {'falls' if b < a else 'rises'} from {old} to {new} {unit}."

    a, b = (part["speed"]["coverage_90"] for part in (before, after))
    return "\n".join(
        (
            "With drag, on paths held out:\n",
            change("the RMSE of speed", "speed", "rmse_m_s", "m/s", 1),
            change("the CRPS of speed", "speed", "crps_m_s", "m/s", 1),
            f"- the 90 % intervals of speed hold {b:.0%} instead of {a:.0%}.",
            change("the CRPS of runout", "runout", "crps_m", "m", 0),
            "",
        )
    )


def _places(found: dict[str, dict[str, Any]]) -> str:
    models = list(found)
    lines = [
        "| place along the path | "
        + " | ".join(f"{m}: RMSE m/s | bias m/s" for m in models)
        + " |",
        "|---|" + "---|---|" * len(models),
    ]
    by_model = {
        m: {r["level"]: r for r in found[m]["speed_misfit"] if r["axis"] == "place_along_path"}
        for m in models
    }
    # Upper, middle and lower third of the track.
    order = {"up": 0, "above": 2}
    for level in sorted(by_model["Coulomb"], key=lambda words: order.get(words.split()[0], 1)):
        cells = [by_model[m][level] for m in models]
        text = " | ".join(f"{c['rmse_m_s']:.1f} | {c['bias_m_s']:+.1f}" for c in cells)
        lines.append(f"| {level} | {text} |")
    return "\n".join([*lines, ""])


def _force(rows: list[dict[str, Any]]) -> str:
    lines = [
        "| speed m/s | stretches | measured force m/s² | their spread | g sinθ m/s² |",
        "|---|---|---|---|---|",
    ]
    rows = sorted(rows, key=lambda row: row["speed_m_s"])
    for third in np.array_split(np.arange(len(rows)), 3):
        mine = [rows[k] for k in third]
        speed = [row["speed_m_s"] for row in mine]
        force = [row["force_m_s2"] for row in mine]
        pull = GRAVITY * np.mean(np.sin(np.radians([row["slope_deg"] for row in mine])))
        lines.append(
            f"| {min(speed):.1f} to {max(speed):.1f} | {len(mine)} | {np.mean(force):.2f} "
            f"| ± {np.std(force, ddof=1):.2f} | {pull:.2f} |"
        )
    return "\n".join([*lines, ""])


def _verdict(document: dict[str, Any]) -> str:
    lines = [
        f"Verdict on the Coulomb block: `{document['verdict']}`"
        + (f", {', '.join(document['missing'])}." if document["missing"] else "."),
        "",
        "| candidate | gain (nats) | p (family-wise) | fitted | what the measured force says |",
        "|---|---|---|---|---|",
    ]
    for row in document["candidates"][:5]:
        witness = row["force_witness"]
        said = "-" if witness is None else f"{witness['value']:.2g} ± {witness['se']:.1g}"
        fitted = ", ".join(f"{value:.2g}" for value in row["parameters"].values()) or "-"
        lines.append(
            f"| {row['effect']} | {row['gain']:.1f} | {row['p_value']:.3f} | {fitted} | {said} |"
        )
    return "\n".join([*lines, "", WITNESS])


def _parameters(models: dict[str, Calibration]) -> str:
    lines = ["| model | parameter | mean ± sd | unit |", "|---|---|---|---|"]
    for model, result in models.items():
        for name, p in result.parameters.items():
            lines.append(f"| {model} | {name} | {p.mean:.3g} ± {p.sd:.2g} | {p.unit or '–'} |")
    return "\n".join([*lines, ""])


def main() -> None:
    """Write the page."""
    page = run(Path(sys.argv[1]) if len(sys.argv) > 1 else RECORDS)
    PAGE.write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
