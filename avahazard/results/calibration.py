"""What a calibration found."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from avahazard.message import message
from avahazard.results.base import ABSENT, Result
from avahazard.results.ladder import BeforeAndAfter

PATHS_DIFFER = message(
    "paths differ by sd {sd} on log friction (evidence {odds}); {model} has no path effect: its "
    "design runouts are too narrow. {remedy}"
)
ODDS, LONG_ODDS = message("{odds} to 1"), message("over 1000 to 1")
ADD_PATHS = message("Add it: avahazard add {model} {effect} --as NEW.")
TOO_FEW_PATHS = message("{n} paths are too few to add it: take them as too narrow.")
HEAVIER_TAILS = message(
    "friction scatters with heavier tails than {model} has, or some records are wrong (likelihood "
    "{odds}): its scatter is too wide, and its law leans on few records. Hold it against a model "
    "made with --tails student."
)
PRIOR_SPEAKS = message(
    "the records say little of {parameter}: in {model} the prior speaks (moved by {moved} of its "
    "standard deviations, {width} as wide)."
)
PRIOR_GIVEN = message("the prior of {parameter} in {model} is {mean} ± {sd}, as it was given.")
PRIOR_FROM = message("the law of {model} has its prior from {source}.")


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

    def note(self, model: str) -> str:
        """The sentence for people."""
        remedy = (
            ADD_PATHS.format(model=model, effect=self.effect)
            if self.effect
            else TOO_FEW_PATHS.format(n=self.n_paths)
        )
        return PATHS_DIFFER.format(
            sd=f"{self.sd:.2f}",
            odds=_odds(self.evidence),
            model=model,
            remedy=remedy,
        )


@dataclass(frozen=True, slots=True)
class HeavierTails(Result):
    """What Student's tails `gain` (nats of log likelihood) over the normal ones of a model."""

    gain: float

    def note(self, model: str) -> str:
        """The sentence for people."""
        return HEAVIER_TAILS.format(model=model, odds=_odds(self.gain))


def _odds(nats: float) -> str:
    odds = math.exp(min(nats, 7.0))
    return ODDS.format(odds=f"{odds:.0f}") if odds < 1000.0 else LONG_ODDS


@dataclass(frozen=True, slots=True)
class PriorDominated(Result):
    """A parameter of which the records say little: the prior speaks.

    `sd_ratio` is the posterior's standard deviation over the prior's, `moved_sd` how far its mean
    moved from the prior's, in standard deviations of that; both in the sampler's coordinate.
    """

    sd_ratio: float
    moved_sd: float

    def note(self, model: str, parameter: str) -> str:
        """The sentence for people."""
        return PRIOR_SPEAKS.format(
            parameter=parameter,
            model=model,
            moved=f"{abs(self.moved_sd):.1f}",
            width=f"{self.sd_ratio:.0%}",
        )


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

    def note(self, model: str, parameter: str) -> str:
        """The sentence for people."""
        return PRIOR_GIVEN.format(
            parameter=parameter, model=model, mean=f"{self.mean:g}", sd=f"{self.sd:g}"
        )


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
    terrain, a record contradicts itself or true volumes are not lognormal.
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
    path_spread: PathSpread | None = field(default=None, metadata=ABSENT)
    heavier_tails: HeavierTails | None = field(default=None, metadata=ABSENT)
    prior_dominated: dict[str, PriorDominated] | None = field(default=None, metadata=ABSENT)
    of_records: tuple[str, ...] | None = field(default=None, metadata=ABSENT)
    prior: PriorTold | None = field(default=None, metadata=ABSENT)
    given_priors: dict[str, GivenTold] | None = field(default=None, metadata=ABSENT)
    created: str | None = field(default=None, metadata=ABSENT)
