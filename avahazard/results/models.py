"""Effects and models as lists show them, what a model was made of, and whether it comes again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from avahazard.results.base import Result, Rows


@dataclass(frozen=True, slots=True)
class EffectParameter(Result):
    """A parameter of an effect: a normal prior cut to its range; at `neutral` it is not there."""

    name: str
    unit: str
    neutral: float
    prior_mean: float
    prior_sd: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True)
class EffectEntry(Result):
    """An effect of the catalogue, and what the present data lack for it (None: nothing)."""

    key: str
    meaning: str
    needs: str
    lacking: str | None


@dataclass(frozen=True, slots=True)
class EffectDetails(EffectEntry):
    """One effect in full: what it acts on, and its parameters."""

    acts_on: str | None
    parameters: Rows[EffectParameter]


@dataclass(frozen=True, slots=True)
class WrittenTemplate(Result):
    """An effect file to start from."""

    file: str


@dataclass(frozen=True, slots=True)
class ModelSummary(Result):
    """A stored model in short."""

    model: str
    parent: str | None
    law: str
    scatter: str
    distribution: str
    method: str
    effects: tuple[str, ...]
    n_events: int
    converged: bool
    created: str


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
