"""What comes down a path in a year: rates, volumes and frictions, by posterior draw.

The block's stop, and its speed at any place, fall steadily as friction rises. So the rate of
avalanches that pass a place, or are faster there, is the rate of those whose friction is under a
threshold, and that is a sum of normal probabilities: no avalanche needs to be drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.inference.likelihood.predicted import Values
from avahazard.inference.model.friction_scatter import below
from avahazard.physics.resistance import Resistance
from avahazard.physics.runout_curve import RunoutCurve

ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""
NODE_STEP = 0.15
MAX_NODES = 48
"""Nodes over log volume: about one for each 15 %."""


@dataclass(frozen=True, slots=True, eq=False)
class EventVolumes:
    """Posterior draws of the rate of avalanches and of the distribution of their volumes.

    `rate` `[n_parameters]` a year; `share` `[n_parameters, n_volumes]` of the avalanches have
    the volumes `log_volume` `[n_volumes]` (log m3, rising), and sum to 1. `seen_only`: they are
    those of the records, which lack what nobody saw.
    """

    rate: Floats
    log_volume: Floats
    share: Floats
    seen_only: bool = False


def one_volume(volume_m3: float, n_parameters: int, rate: float = 1.0) -> EventVolumes:
    """Avalanches of one volume at a known rate."""
    return EventVolumes(
        np.full(n_parameters, rate), np.array([np.log(volume_m3)]), np.ones((n_parameters, 1))
    )


def event_volumes(
    rate: Floats, rate_over: Callable[[Floats], Floats], low: float, high: float
) -> EventVolumes:
    """Gather a frequency on nodes between two log volumes.

    `rate_over` maps log volumes `[n]` to the yearly rates of larger avalanches
    `[n_parameters, n]`; what lies past the ends counts at the end nodes.
    """
    n = int(np.clip(np.ceil((high - low) / NODE_STEP) + 1, 1, MAX_NODES))
    nodes = np.linspace(low, high, n)
    over = rate_over(0.5 * (nodes[1:] + nodes[:-1]))
    ends = np.zeros((len(rate), 1))
    over = np.minimum(np.hstack([rate[:, None], over, ends]), rate[:, None])
    with np.errstate(invalid="ignore", divide="ignore"):
        share = -np.diff(np.minimum.accumulate(over, axis=1), axis=1) / rate[:, None]
    # A rate of nought has no volumes: any will do.
    share[rate <= 0.0] = 1.0 / n
    return EventVolumes(rate, nodes, share)


def with_volumes(volumes: EventVolumes, log_volume: Floats) -> EventVolumes:
    """The same with nodes at more log volumes, which have no share."""
    more = np.setdiff1d(log_volume, volumes.log_volume)
    nodes = np.concatenate([volumes.log_volume, more])
    share = np.hstack([volumes.share, np.zeros((len(volumes.rate), len(more)))])
    order = np.argsort(nodes)
    return replace(volumes, log_volume=nodes[order], share=share[:, order])


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
