"""Regressions of posteriordb with their reference draws."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np


def reference_regression(shared_data: Path, name: str):
    """x, y, prior mean and sd of (alpha, beta), and [3, 2] reference means and sds."""
    folder = shared_data / "posteriordb"
    file = next(folder.glob(f"{name}*_data.json"))
    data = json.loads(file.read_text(encoding="utf-8"))
    table = next(folder.glob(f"{name}*summary.csv")).read_text(encoding="utf-8").splitlines()
    reference = np.array([[float(v) for v in row.split(",")[2:4]] for row in table[1:]])
    if name == "kilpisjarvi":
        x, y = np.array(data["x"], float), np.array(data["y"], float)
        mean = np.array([data["pmualpha"], data["pmubeta"]])
        return x, y, mean, np.array([data["psalpha"], data["psbeta"]]), reference
    canopy = np.array([data[k] for k in ("diam1", "diam2", "canopy_height")]).prod(axis=0)
    return np.log(canopy), np.log(data["weight"]), np.zeros(2), np.full(2, np.inf), reference
