"""Effects and models, as lists show them."""

from __future__ import annotations

from dataclasses import dataclass

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
class EffectDetails(Result):
    """One effect in full: what it acts on, and its parameters."""

    key: str
    meaning: str
    needs: str
    lacking: str | None
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
