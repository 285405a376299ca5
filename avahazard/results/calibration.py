"""What a calibration found."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.results.base import ABSENT, Result
from avahazard.results.ladder import BeforeAndAfter


@dataclass(frozen=True, slots=True)
class ParameterSummary(Result):
    """Posterior of one parameter: mean, standard deviation, mode, 5 and 95 % quantiles."""

    mean: float
    sd: float
    mode: float
    q05: float
    q95: float
    unit: str


@dataclass(frozen=True, slots=True)
class Convergence(Result):
    """The worst figures over all parameters; `converged` only when all of them pass."""

    rhat_max: float | None
    ess_bulk_min: float
    ess_tail_min: float
    acceptance: float
    divergent_or_stuck_chains: int
    converged: bool


@dataclass(frozen=True, slots=True)
class Calibration(Result):
    """A calibrated model: what it is made of, its parameters, and whether its chains converged.

    `left_out` counts events that the method cannot use, by the reason; path offsets are
    `path:PATH_ID` among the parameters. Of a child made by `add`, `comparison` holds the scores
    before and after.
    """

    model: str
    parent: str | None
    law: str
    scatter: str
    distribution: str
    tails: str
    centrifugal: bool
    method: str
    effects: tuple[str, ...]
    n_events: int
    left_out: dict[str, int]
    parameters: dict[str, ParameterSummary]
    diagnostics: Convergence
    chains: int
    draws: int
    seed: int
    data_fingerprint: str
    notes: tuple[str, ...]
    comparison: BeforeAndAfter | None = field(default=None, metadata=ABSENT)
    created: str | None = field(default=None, metadata=ABSENT)
