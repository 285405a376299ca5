"""The loop on real records: what was held back, what was named, and whether the error fell.

Runs the data sets that are named (default: all), keeps what came out in benchmarks/real_data.json,
and writes docs/real-data.md of it. The records are not part of the project: their folder is
../shared/data. Run from the root of the checkout: make real-data, or for
one: .venv/bin/python benchmarks/real_data.py NAME
"""

from __future__ import annotations

import csv
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from real_data_page import page
from real_data_regression import Regression, regression_scores

from avahazard.workflow.add import add
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import init_database
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.import_files import import_files
from avahazard.workflow.predict import predict

ROOT = Path(__file__).resolve().parents[1]
FOUND = ROOT / "benchmarks" / "real_data.json"
PAGE = ROOT / "docs" / "real-data.md"
RECORDS = ROOT.parent / "shared" / "data"
SPLIT_SEED = 13
"""Of the third that is kept back: the number of the issue, and tried with no other."""
MOST_ROUNDS = 2


@dataclass(frozen=True, slots=True)
class DataSet:
    """A folder of records, the law it is read by, and what was expected before looking."""

    folder: str
    law: str
    expect: tuple[str, ...] = ()
    keeps_third: bool = True
    regressions: tuple[Regression, ...] = ()


DATA_SETS = (
    DataSet(
        "rock-avalanches-canada",
        "power",
        ("covariate:confinement",),
        regressions=(Regression(), Regression(levels=("confinement",))),
    ),
    DataSet(
        "submarine-slides",
        "power",
        regressions=(Regression(), Regression(cubic=("mean_slope_deg",))),
    ),
    DataSet("avanodes", "constant", keeps_third=False),
)


def run(data: DataSet) -> dict[str, Any]:
    """Calibrate, ask what is missing, add it; score every model on what was kept back."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        database = str(folder / "real.db")
        source, kept = RECORDS / data.folder, None
        found: dict[str, Any] = {"law": data.law, "expect": list(data.expect), "rounds": []}
        if data.keeps_third:
            source, kept = split(source / "events.csv", folder)
            found["regressions"] = [
                {"name": r.name, **regression_scores(source, kept, r)} for r in data.regressions
            ]
        init_database(database)
        import_files(database, [source])
        calibrate(database, "model-0", law=data.law)
        for k in range(MOST_ROUNDS + 1):
            verdict = diagnose_model(
                database, f"model-{k}", expect=data.expect if k == 0 else ()
            ).to_dict()
            found["rounds"].append(scored(database, f"model-{k}", kept) | {"diagnosis": verdict})
            if not addable(verdict) or k == MOST_ROUNDS:
                break
            add(database, f"model-{k}", verdict["missing"], f"model-{k + 1}")
        found["n_events"] = found["rounds"][0]["compare"]["scores"]["runout"]["n"]
        if data.expect:
            # What was declared is scored too, whether it was named or not.
            add(database, "model-0", list(data.expect), "declared")
            found["declared"] = scored(database, "declared", kept)
        return found


def addable(verdict: dict[str, Any]) -> bool:
    """Whether one effect is named, or one column that no physics explains, as a user may add it."""
    missing = verdict["missing"]
    if len(missing) != 1:
        return False
    return verdict["verdict"] == "missing-effect" or missing[0].startswith("covariate:")


def scored(database: str, model: str, kept: Path | None) -> dict[str, Any]:
    """Scores by folds or paths held out, and on the third that nothing has seen."""
    compared = compare(database, model).to_dict()
    slim = {key: compared[key] for key in ("coordinate", "scores", "held_out")}
    third = None if kept is None else predict(database, model, kept).scores
    return {"compare": slim, "kept": None if third is None else third.to_dict()}


def split(events: Path, folder: Path) -> tuple[Path, Path]:
    """Two thirds of the rows to learn from, and a third drawn at random to judge by."""
    with events.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    order = np.random.default_rng(SPLIT_SEED).permutation(len(rows))
    third = set(order[: len(rows) // 3].tolist())
    files = folder / "events.csv", folder / "kept.csv"
    for path, kept in zip(files, (False, True), strict=True):
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows(
                [head, *(r for i, r in enumerate(rows) if kept == (i in third))]
            )
    return files


def main(names: list[str]) -> None:
    """Run what is named, keep it, and write the page of all that was kept."""
    known = {data.folder: data for data in DATA_SETS}
    for name in names or list(known):
        result = run(known[name])
        found = json.loads(FOUND.read_text()) if FOUND.exists() else {}
        found[name] = result
        FOUND.write_text(json.dumps(found, indent=1) + "\n")
    PAGE.write_text(page(json.loads(FOUND.read_text())))


if __name__ == "__main__":
    main(sys.argv[1:])
