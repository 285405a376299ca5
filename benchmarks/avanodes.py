"""A Coulomb block and drag against speeds measured inside four avalanches: docs/avanodes.md.

make avanodes, or … -m benchmarks.avanodes FOLDER. The records are not part of the project.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from avahazard.physics.cells import GRAVITY
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest
from benchmarks.study import DOCS, SHARED, Line, table, write_parts

PLAIN, DRAG = "Coulomb", "with drag"


def tables(records: Path) -> dict[str, str]:
    """Calibrate without and with drag on `records`; the tables of the page."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "avanodes.db")
        init_database(database)
        import_files(database, [records])
        models = {PLAIN: calibrate(database, "coulomb", CalibrateRequest(law="constant"))}
        found = {PLAIN: compare(database, "coulomb").to_dict()}
        verdict = diagnose_model(database, "coulomb", DiagnoseRequest()).to_dict()
        models[DRAG] = add(database, "coulomb", ["turbulent-drag"], "drag")
        found[DRAG] = compare(database, "drag").to_dict()
    parameters = [
        (model, name, f"{p.mean:.3g} ± {p.sd:.2g}", p.unit or "–")
        for model, result in models.items()
        for name, p in result.parameters.items()
    ]
    return {
        "scores": _scores(found),
        "places": _places(found),
        "force": _force(found[PLAIN]["measured_force"]),
        "verdict": _verdict(verdict),
        "parameters": table(("model", "parameter", "mean ± sd", "unit"), parameters),
    }


def _scores(found: dict[str, Line]) -> str:
    head = ("model", "speeds", "RMSE m/s", "bias m/s", "CRPS m/s", "within 50 %", "within 90 %",
            "runout RMSE m", "runout CRPS m")  # fmt: skip
    rows = []
    for part, words in (("scores", "in-sample"), ("held_out", "held-out path")):
        for model, document in found.items():
            speed, runout = document[part]["speed"], document[part]["runout"]
            rows.append(
                (model, words, f"{speed['rmse_m_s']:.1f}", f"{speed['bias_m_s']:+.1f}",
                 f"{speed['crps_m_s']:.1f}", f"{speed['coverage_50']:.0%}",
                 f"{speed['coverage_90']:.0%}", f"{runout['rmse_m']:.0f}",
                 f"{runout['crps_m']:.0f}")
            )  # fmt: skip
    floor = found[PLAIN]["scores"]["speed"]["noise_floor_m_s"]
    return f"{table(head, rows)}\n\nMeasurement-error floor of the speeds: {floor:.1f} m/s."


def _places(found: dict[str, Line]) -> str:
    """By the upper, middle and lower third of the track."""
    by_level: dict[str, list[str]] = {}
    for document in found.values():
        for row in document["speed_misfit"]:
            if row["axis"] == "place_along_path":
                cells = (f"{row['rmse_m_s']:.1f}", f"{row['bias_m_s']:+.1f}")
                by_level.setdefault(row["level"], []).extend(cells)
    order = {"up": 0, "above": 2}
    levels = sorted(by_level, key=lambda words: order.get(words.split()[0], 1))
    head = [cell for model in found for cell in (f"{model}: RMSE m/s", "bias m/s")]
    return table(("place along the path", *head), [(level, *by_level[level]) for level in levels])


def _force(rows: list[Line]) -> str:
    found = []
    for third in np.array_split(sorted(rows, key=lambda row: row["speed_m_s"]), 3):
        speed = [row["speed_m_s"] for row in third]
        force = [row["force_m_s2"] for row in third]
        pull = GRAVITY * np.mean(np.sin(np.radians([row["slope_deg"] for row in third])))
        found.append(
            (f"{min(speed):.1f} to {max(speed):.1f}", len(third), f"{np.mean(force):.2f}",
             f"± {np.std(force, ddof=1):.2f}", f"{pull:.2f}")
        )  # fmt: skip
    head = ("speed m/s", "stretches", "measured force m/s²", "their spread", "g sinθ m/s²")
    return table(head, found)


def _verdict(document: Line) -> str:
    rows = []
    for row in document["candidates"][:5]:
        witness = row["force_witness"]
        said = "-" if witness is None else f"{witness['value']:.2g} ± {witness['se']:.1g}"
        fitted = ", ".join(f"{value:.2g}" for value in row["parameters"].values()) or "-"
        rows.append((row["effect"], f"{row['gain']:.1f}", f"{row['p_value']:.3f}", fitted, said))
    head = ("candidate", "gain (nats)", "p (family-wise)", "fitted", "measured force")
    named = ", ".join([f"`{document['verdict']}`", *document["missing"]])
    return f"Verdict on the Coulomb block: {named}.\n\n{table(head, rows)}"


if __name__ == "__main__":
    records = Path(sys.argv[1]) if len(sys.argv) > 1 else SHARED / "avanodes"
    write_parts(DOCS / "avanodes.md", tables(records))
