"""What comes down a path in a year: rates, volumes and frictions, by posterior draw.

The block's stop, and its speed at any place, fall steadily as friction rises. So the rate of
avalanches that pass a place, or are faster there, is the rate of those whose friction is under a
threshold, and that is a sum of normal probabilities: no avalanche needs to be drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.inference.likelihood.block_runs import Values
from avahazard.inference.model.friction_scatter import below
from avahazard.physics.resistance import Resistance
from avahazard.physics.runout_curve import RunoutCurve

LEAST_SCATTER = 1e-9
HALVINGS = 24


@dataclass(frozen=True, slots=True, eq=False)
class Avalanches:
    """Avalanches of one path: classes of release and columns, volumes, and posterior draws.

    Of `volumes.rate` `[n_parameters]` avalanches a year `class_share` `[n_classes]` are of each
    class, whatever the volume. Friction has `location` (log μ, or μ where it is normal) and
    `scatter`, both `[n_parameters, n_classes, n_volumes]`; path offsets are in them. Draw p runs
    by `curves[group[p]]`, of which row c is that of class c; `values` are the effects' parameters
    there, and `ahead` `[n_groups][n_classes]` is how far (m) the front is ahead of the block.
    `sigma_m` `[n_parameters]`: the stops scatter in metres instead (metropolis). `kept` is for what
    is made of these once.
    """

    site: Site
    release: NDArray[np.int64]
    volumes: EventVolumes
    class_share: Floats
    location: Floats
    scatter: Floats
    group: NDArray[np.int64]
    curves: tuple[RunoutCurve, ...]
    values: tuple[Values, ...]
    resistances: tuple[Resistance, ...]
    ahead: tuple[Floats, ...]
    in_log: bool
    student: bool
    sigma_m: Floats | None
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    @property
    def n_parameters(self) -> int:
        """Number of posterior draws."""
        return len(self.location)

    @property
    def n_classes(self) -> int:
        """Number of classes of release and columns."""
        return len(self.class_share)


def least_scatter(avalanches: Avalanches) -> Floats:
    """The scatter of friction, never quite nought; nought for one with scatter in metres."""
    whole = (
        np.zeros_like(avalanches.scatter) if avalanches.sigma_m is not None else avalanches.scatter
    )
    return np.maximum(whole, LEAST_SCATTER)


def friction_below(avalanches: Avalanches, mu: Floats) -> Floats:
    """Chance that the friction of an avalanche lies under `mu` `[n_parameters, n_classes]`.

    The chance is `[n_parameters, n_classes, n_volumes]`; friction that is normal is taken given
    that it is over 0.
    """
    scatter = least_scatter(avalanches)
    mu = np.maximum(mu, 0.0)[:, :, None]
    if avalanches.in_log:
        with np.errstate(divide="ignore"):
            return below((np.log(mu) - avalanches.location) / scatter, avalanches.student)
    impossible = below(-avalanches.location / scatter, avalanches.student)
    under = below((mu - avalanches.location) / scatter, avalanches.student)
    return np.asarray((under - impossible) / np.maximum(1.0 - impossible, 1e-300))


def yearly_rate(avalanches: Avalanches, chance: Floats) -> Floats:
    """Yearly rate `[n_parameters]` of what has this chance for an avalanche.

    `chance` `[n_parameters, n_classes, n_volumes]`, of each class and volume.
    """
    by_class = np.einsum("pcv,pv->pc", chance, avalanches.volumes.share)
    return np.asarray(avalanches.volumes.rate * (by_class @ avalanches.class_share))


def exceeded(
    rate_over: Callable[[Floats], Floats], rate: Floats | float, low: float, high: float, n: int
) -> Floats:
    """The level `[n]` that is exceeded at a yearly `rate` (`[n]` or one for all), by bisection.

    `rate_over` maps levels `[n]` to the yearly rates of what exceeds them, falling in the level.
    The result is `high` or inf: inf where even `high` is exceeded more often; `low` where `low`
    is exceeded less often.
    """
    bottom, top = np.full(n, low), np.full(n, high)
    beyond = rate_over(top) >= rate
    for _ in range(HALVINGS):
        middle = 0.5 * (bottom + top)
        often = rate_over(middle) >= rate
        bottom, top = np.where(often, middle, bottom), np.where(often, top, middle)
    # Nothing was ever often enough: the lowest level itself.
    level = np.where(bottom == low, low, 0.5 * (bottom + top))
    return np.where(beyond, np.inf, level)


def annual_rate(return_period_years: float) -> float:
    """The yearly rate at which a year has one or more with chance 1/T: -log(1 - 1/T); T > 1."""
    return float(-np.log1p(-1.0 / return_period_years))
