"""What a calibration found."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows
from avahazard.results.comparison import BeforeAndAfter


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

    @property
    def ess_min(self) -> float:
        """The smallest effective sample size, of the bulk and of the tails."""
        return min(self.ess_bulk_min, self.ess_tail_min)


@dataclass(frozen=True, slots=True)
class PathSpread(Result):
    """What the records say of a spread between paths that the model lacks.

    `sd` is on log friction, `evidence` in nats; `effect` is what would take it up, None where
    there are too few paths to add it.
    """

    sd: float
    evidence: float
    n_paths: int
    effect: str | None

    def note(self, model: str) -> Note:
        """The note of a model on it."""
        remedy = Note("too_few_paths", n=self.n_paths)
        if self.effect:
            remedy = Note("add_effect", model=model, effect=self.effect)
        return Note("paths_differ", sd=self.sd, nats=self.evidence, model=model, remedy=remedy)


@dataclass(frozen=True, slots=True)
class HeavierTails(Result):
    """What Student's tails `gain` (nats of log likelihood) over the normal ones of a model."""

    gain: float

    def note(self, model: str) -> Note:
        """The note of a model on it."""
        return Note("heavier_tails", model=model, nats=self.gain)


@dataclass(frozen=True, slots=True)
class PriorDominated(Result):
    """A parameter that the records hardly narrow: it is prior-dominated.

    `sd_ratio` is the posterior's standard deviation over the prior's, `moved_sd` how far its mean
    moved from the prior's, in standard deviations of that; both in the sampler's coordinate.
    """

    sd_ratio: float
    moved_sd: float

    def note(self, model: str, parameter: str) -> Note:
        """The note of a model on it."""
        moved, width = abs(self.moved_sd), self.sd_ratio
        return Note("prior_dominated", parameter=parameter, model=model, moved=moved, width=width)


@dataclass(frozen=True, slots=True)
class PriorCoordinate(Result):
    """Mean and standard deviation of a normal prior of one coordinate of the law."""

    mean: float
    sd: float


@dataclass(frozen=True, slots=True)
class PriorTold(Result):
    """The prior of the law from elsewhere: its `source`, and its coordinates.

    The source is a model, `fit:` and paths, or `given:` and the parameters of the numbers.
    """

    source: str
    coordinates: dict[str, PriorCoordinate]


@dataclass(frozen=True, slots=True)
class GivenTold(Result):
    """The prior of a parameter as it was given: mean and standard deviation in its own `unit`."""

    mean: float
    sd: float
    unit: str

    def note(self, model: str, parameter: str) -> Note:
        """The note of a model on it."""
        return Note("prior_given", parameter=parameter, model=model, mean=self.mean, sd=self.sd)


@dataclass(frozen=True, slots=True)
class InCommon(Result):
    """A column, or one level of it, that goes with the second kind of avalanche.

    `correlation` is that of ranks with the probability to be of it; the p-value is corrected for
    the number of columns.
    """

    column: str
    level: str | None
    correlation: float
    p_value: float


@dataclass(frozen=True, slots=True)
class Kinds(Result):
    """A second kind of avalanche that no column records.

    `share` of the avalanches are of it, with log friction lower by -`shift`; the probability is
    that of each event, by its name, to be one of them.
    """

    share: float
    shift: float
    probability: dict[str, float]
    in_common: Rows[InCommon]


@dataclass(frozen=True, slots=True)
class Calibration(Result):
    """A calibrated model: what it is made of, its parameters, and whether its chains converged.

    `left_out` counts events that the method cannot use, by the reason; path offsets are
    `path:PATH_ID` among the parameters. Of a child made by `add`, `comparison` holds the scores
    before and after. `prior` is there where the law's came from elsewhere, `given_priors` where
    some were given as numbers (by parameter), `path_spread`
    where paths differ and the model does not know it, `heavier_tails` where friction scatters with
    such and the model's are normal, `prior_dominated` where the records hardly
    narrow a parameter (by its coordinate), `of_records` (notes too) where a path misses its
    terrain, a record contradicts itself or true volumes are not lognormal, `kinds` where there are
    two that no column records. `forward` is what runs. `next` is the step to do now.
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
    path_spread: PathSpread | None = field(default=None, metadata=ABSENT)
    heavier_tails: HeavierTails | None = field(default=None, metadata=ABSENT)
    prior_dominated: dict[str, PriorDominated] | None = field(default=None, metadata=ABSENT)
    of_records: tuple[Note, ...] | None = field(default=None, metadata=ABSENT)
    prior: PriorTold | None = field(default=None, metadata=ABSENT)
    given_priors: dict[str, GivenTold] | None = field(default=None, metadata=ABSENT)
    kinds: Kinds | None = field(default=None, metadata=ABSENT)
    created: str | None = field(default=None, metadata=ABSENT)
    forward: str = "block"
    next: Note | None = field(default=None, metadata=ABSENT)
