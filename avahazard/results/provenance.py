"""What is needed to make a model again, and whether that gives the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avahazard.results.base import Result


@dataclass(frozen=True, slots=True)
class Surroundings(Result):
    """Versions of the package and of what its numbers rest on, and the hash of the lock file.

    `lock_sha256` is None where the program does not run beside its lock file.
    """

    versions: dict[str, str]
    lock_sha256: str | None


@dataclass(frozen=True, slots=True)
class Provenance(Result):
    """All that a model was made of.

    `made_with` is None for models that were stored before it was kept; `effect_sha256` is that of
    the user's effect files, None without any. `paths` are those calibrated on, none: all.
    """

    model: str
    parent: str | None
    created: str
    data_fingerprint: str
    records_changed: bool
    specification: dict[str, Any]
    method: str
    paths: tuple[str, ...]
    chains: int
    draws: int
    seed: int
    effect_sha256: str | None
    made_with: Surroundings | None
    now: Surroundings


@dataclass(frozen=True, slots=True)
class Difference(Result):
    """A parameter that came out differently: its means, and the largest difference of a draw."""

    stored_mean: float
    new_mean: float
    largest: float


@dataclass(frozen=True, slots=True)
class Rerun(Result):
    """A calibration done again: whether every draw is the same to the last bit, and where not."""

    model: str
    identical: bool
    n_parameters: int
    differences: dict[str, Difference]
    notes: tuple[str, ...]
