"""What a calibration found, what a model was made of, and models and effects as lists."""

from dataclasses import field
from typing import Any

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows
from avahazard.results.comparison import BeforeAndAfter


class ParameterSummary(Result):
    """Posterior of one parameter: mean, standard deviation, mode, 5 and 95 % quantiles."""

    mean: float
    sd: float
    mode: float
    q05: float
    q95: float
    unit: str


class Convergence(Result):
    """The worst figures over all parameters; `converged` only when all of them pass."""

    rhat_max: float | None
    ess_bulk_min: float
    ess_tail_min: float
    acceptance: float
    divergent_or_stuck_chains: int
    converged: bool

    @property
    def ess_min(self) -> float:
        """The smallest effective sample size, of the bulk and of the tails."""
        return min(self.ess_bulk_min, self.ess_tail_min)


class InCommon(Result):
    """A column, or one level of it, that goes with the second kind of avalanche.

    The rank correlation is with the probability to be of it, its p-value is for all columns.
    """

    column: str
    level: str | None
    correlation: float
    p_value: float


class Kinds(Result):
    """A second kind of avalanche that no column records.

    `share` of the avalanches are of it, with log friction lower by -`shift`; the probability is
    that of each event, by its name, to be one of them.
    """

    share: float
    shift: float
    probability: dict[str, float]
    in_common: Rows[InCommon]


class Calibration(Result):
    """A calibrated model: what it is made of, its parameters, and whether its chains converged.

    `left_out` counts events that the method cannot use, by the reason. A child made by `add` has
    its `comparison` with the parent, a model with `two-kinds` its `kinds`. `forward` is what runs.
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
    notes: tuple[Note, ...]
    comparison: BeforeAndAfter | None = field(default=None, metadata=ABSENT)
    kinds: Kinds | None = field(default=None, metadata=ABSENT)
    created: str | None = field(default=None, metadata=ABSENT)
    forward: str = "block"
    next: Note | None = field(default=None, metadata=ABSENT)


class EffectParameter(Result):
    """A parameter of an effect: a normal prior cut to its range; at `neutral` it is not there."""

    name: str
    unit: str
    neutral: float
    prior_mean: float
    prior_sd: float
    low: float | None
    high: float | None


class EffectEntry(Result):
    """An effect of the catalogue, and what the present data lack for it (None: nothing)."""

    key: str
    meaning: str
    needs: str
    lacking: str | None


class EffectDetails(EffectEntry):
    """One effect in full: what it acts on, and its parameters."""

    acts_on: str | None
    parameters: Rows[EffectParameter]


class WrittenTemplate(Result):
    """An effect file to start from."""

    file: str


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


class Surroundings(Result):
    """Versions of the package and of what its numbers rest on; the lock file's hash, if any."""

    versions: dict[str, str]
    lock_sha256: str | None


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


class Difference(Result):
    """A parameter that differs when repeated: its means, and the largest difference of a draw."""

    stored_mean: float
    new_mean: float
    largest: float


class Rerun(Result):
    """A calibration done again: whether every draw is the same to the last bit, and where not."""

    model: str
    identical: bool
    n_parameters: int
    differences: dict[str, Difference]
    notes: tuple[str, ...]
