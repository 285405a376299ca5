"""Datasets as arrays, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from avahazard.records.collection import Records
from avahazard.synth.making import make_dataset


def truth_column(truth: dict[str, Any], name: str) -> Any:
    """One column of the true events."""
    return np.array([event[name] for event in truth["events"]])


def residuals(truth: dict[str, Any]) -> Any:
    """log μ less its median, in units of the true scatter."""
    apart = np.log(truth_column(truth, "mu") / truth_column(truth, "mu_median"))
    return apart / truth_column(truth, "scatter")


def dataset(seed: int, **options: Any) -> tuple[Records, dict[str, Any]]:
    """A dataset, with a truth that tests may look into."""
    return make_dataset(seed, **options)
