"""What a model is made of, and the priors that are not the program's own.

Priors come from other records (a fit, another model's posterior), or are numbers that people give.
From other records the law has a normal on its coordinates, with their covariance. What they say of
the scatter is not taken over: it holds their errors too where the method does not know them. Of a
given parameter that is positive the log is sampled, with the lognormal of the mean and standard
deviation given; one of either sign has their normal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Setting
from avahazard.inference.model.choices import (
    BLOCK,
    DistributionName,
    ForwardName,
    ScatterName,
    TailsName,
)
from avahazard.inference.model.laws import Law, differences
from avahazard.records.errors import AvahazardError

LEAST_RECIPROCAL_CONDITION = 1e-10


@dataclass(frozen=True, slots=True)
class LawPrior:
    """Mean `[n_coordinates]` and covariance of the coordinates of `law`, from `source`.

    The source is the name of a model, or `fit:` and the paths whose events were fitted.
    """

    source: str
    law: str
    mean: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]

    @property
    def sd(self) -> Floats:
        """Standard deviations `[n_coordinates]`."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Correlations `[n_coordinates, n_coordinates]`."""
        return np.asarray(np.array(self.covariance) / np.outer(self.sd, self.sd))


def law_prior(source: str, law: Law, mean: Floats, covariance: Floats) -> LawPrior:
    """The prior of these coordinates. Raises `AvahazardError` where some are missing."""
    prior = LawPrior(source, law.name, tuple(mean.tolist()), tuple(map(tuple, covariance.tolist())))
    known = np.isfinite(mean).all() and np.isfinite(covariance).all() and (prior.sd > 0.0).all()
    if not known or np.linalg.eigvalsh(prior.correlation)[0] < LEAST_RECIPROCAL_CONDITION:
        raise AvahazardError(
            f"{source} does not fix the constants of the {law.name} law: it is no prior of them.",
            "Take a law with fewer constants, or another model.",
        )
    return prior


def prior_of_fit(
    source: str, law: Law, natural: Floats, covariance: Floats, n_points: int
) -> LawPrior:
    """The prior that a fit by least squares gives, by its natural constants and their covariance.

    Carried to the coordinates by the derivatives there. The residual variance is known from
    `n_points` less the constants only: the covariance is that of the t that follows. Raises
    `AvahazardError` where there are too few points for one.
    """
    free = n_points - len(law.coordinates)
    if free < 3:
        raise AvahazardError(
            f"{source} stands on {n_points} events, which leaves the error of its law open.",
            f"A prior needs a fit to {len(law.coordinates) + 3} events or more.",
        )
    scale = np.where(natural != 0.0, np.abs(natural), 1e-8)
    slope = (differences(law.from_natural, natural, scale) / scale[:, None]).T
    spread = slope @ covariance @ slope.T * (free / (free - 2.0))
    return law_prior(source, law, law.from_natural(natural), spread)


GIVEN = "given:"
"""A source of a law's prior that begins so are numbers, of the parameters that it lists."""

LEAST_WIDTH, MOST_WIDTH = 1e-4, 100.0
"""Standard deviations that are taken, over those of the program's own weak prior."""
FAR = 1e3
"""Of the order of one are coordinates: so far off, a parameter that can be negative is."""


@dataclass(frozen=True, slots=True)
class GivenPrior:
    """Mean and standard deviation of the parameter `name`, in its unit, before any record."""

    name: str
    mean: float
    sd: float

    @property
    def in_log(self) -> tuple[float, float]:
        """Mean and standard deviation of the log of what is lognormal with these."""
        spread = math.log1p((self.sd / self.mean) ** 2)
        return math.log(self.mean) - 0.5 * spread, math.sqrt(spread)


def require_possible(given: GivenPrior, positive: bool) -> None:
    """Raise `AvahazardError` where these are not the mean and sd of such a parameter."""
    told = f"{given.name}={given.mean:g},{given.sd:g}"
    if not (math.isfinite(given.mean) and math.isfinite(given.sd) and given.sd > 0.0):
        raise AvahazardError(
            f"The prior {told} is none: it takes a mean and a standard deviation over 0.",
            "Such as --prior a=0.5,0.05.",
        )
    if positive and given.mean <= 0.0:
        raise AvahazardError(
            f"The prior {told} is none: {given.name} is positive.",
            f"Give a mean over 0; the prior of {given.name} is then lognormal.",
        )


def require_width(name: str, sd: float, weak: float) -> None:
    """Refuse an `sd` in the sampler's coordinate too narrow or wide beside the `weak` one."""
    if not LEAST_WIDTH <= sd / weak <= MOST_WIDTH:
        raise AvahazardError(
            f"The prior of {name} has a standard deviation {sd / weak:.1e} times that of the weak "
            "prior that it replaces.",
            f"It may be {LEAST_WIDTH:g} to {MOST_WIDTH:g} times that; give it in the unit that "
            "`avahazard model` shows.",
        )


def given_law_prior(law: Law, given: Sequence[GivenPrior]) -> LawPrior | None:
    """The prior of a law some of whose parameters have one; None where none of them has.

    A given parameter is independent of the others. Where one is not given, its coordinate keeps
    its weak prior, independent of the parameters before it: without μ∞, that of μ∞/a stays.
    Coordinates are lines in the parameters or, where these are positive, in their logs.
    """
    selected = {g.name: g for g in given if g.name in free_parameters(law)}
    if not selected:
        return None
    names = free_parameters(law)
    start, slope = _lines(law, names)
    d = len(names)
    # Independent w: of the parameter where it is given, else of the coordinate. z: parameters.
    centre, spread, shift, mix = np.zeros(d), np.zeros(d), np.zeros(d), np.zeros((d, d))
    for k, name in enumerate(names):
        if name in selected:
            told = selected[name]
            centre[k], spread[k] = (
                told.in_log if name in positive_parameters(law) else (told.mean, told.sd)
            )
            require_width(name, spread[k] * abs(slope[k, k]), law.prior_sd[k])
            mix[k, k] = 1.0
            continue
        centre[k], spread[k] = law.prior_mean[k], law.prior_sd[k]
        shift[k] = -(start[k] + slope[k, :k] @ shift[:k]) / slope[k, k]
        mix[k] = -(slope[k, :k] @ mix[:k]) / slope[k, k]
        mix[k, k] = 1.0 / slope[k, k]
    turned = slope @ mix
    mean = start + slope @ shift + turned @ centre
    covariance = (turned * spread**2) @ turned.T
    return law_prior(GIVEN + ",".join(selected), law, mean, covariance)


def free_parameters(law: Law) -> tuple[str, ...]:
    """The parameters that a calibration moves, one a coordinate: b of the rational law is 1."""
    base = law.to_natural(law.prior_mean)
    moved = law.to_natural(law.prior_mean + np.eye(len(law.prior_mean))) != base
    return tuple(n for n, free in zip(law.names, moved.any(axis=0), strict=True) if free)


def positive_parameters(law: Law) -> tuple[str, ...]:
    """Those of the free parameters that no coordinate can make negative."""
    far = law.to_natural(law.prior_mean - FAR * np.eye(len(law.prior_mean)))
    least = dict(zip(law.names, far.min(axis=0), strict=True))
    return tuple(name for name in free_parameters(law) if least[name] >= 0.0)


def _lines(law: Law, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Coordinates `[d]` where all parameters are 1 or 0, and their slopes `[d, d]` over each."""
    positive = np.isin(law.names, positive_parameters(law))
    fixed = ~np.isin(law.names, names)
    origin = np.where(fixed, law.to_natural(law.prior_mean), np.where(positive, 1.0, 0.0))
    start = law.from_natural(origin)
    columns = []
    for name in names:
        k = law.names.index(name)
        ahead = origin.copy()
        ahead[k] = np.e if positive[k] else 1.0
        columns.append(law.from_natural(ahead) - start)
    return start, np.column_stack(columns)


@dataclass(frozen=True, slots=True)
class Specification:
    """A friction law (of `laws.LAWS`) with its scatter and the effects added to the block.

    `distribution` is that of friction given volume; `tails` `student` lets friction scatter as
    Student's t with 4 degrees of freedom, which is robust to outliers. `centrifugal` keeps the
    load of curvature on the bed. `forward` names what runs: the block, or the flow model whose
    stored runs stand in its place. `reference_volume_m3` scales the coordinate of a scatter that
    changes with volume; it is taken from the data of the calibration. `prior` is that of the law,
    from other records or from numbers; None for the law's own weak one. `given` are the numbers,
    of parameters of the law and others.
    """

    law: str = "exponential"
    scatter: ScatterName = "constant"
    distribution: DistributionName = "lognormal"
    tails: TailsName = "normal"
    effects: tuple[str, ...] = ()
    centrifugal: bool = True
    forward: ForwardName = BLOCK
    reference_volume_m3: float = 1e5
    prior: LawPrior | None = None
    given: tuple[GivenPrior, ...] = ()

    def has(self, effect: Definition) -> bool:
        """Whether the effect is there, added or as a setting."""
        setting = effect.changes
        if setting is not None and setting.value is not None and self.of(setting) == setting.value:
            return True
        return effect.key in self.effects

    def of(self, setting: Setting) -> Any:
        """The present value of a setting."""
        return getattr(self, setting.field)

    def put(self, setting: Setting, value: Any) -> Specification:
        """The specification with another value of a setting."""
        return replace(self, **{setting.field: value})
