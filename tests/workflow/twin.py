"""The twin of data/, whole or by path, and the law that it was made with."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.collection import Records, only_paths
from avahazard.records.reading import read_records

DATA = Path(__file__).resolve().parents[2] / "data"
TRUTH = {"a": 0.519, "n": 3.36e-7, "sigma": 0.158}
FEW_PATHS = ("scey", "saugy", "entremene")


@cache
def twin_records() -> Records:
    """All records of the twin."""
    return read_records([DATA])


@cache
def twin_study(*paths: str) -> Observations:
    """The observations of these paths of the twin; of all where none are named."""
    return build_observations(only_paths(twin_records(), paths))
