"""How often avalanches run past a place, and the runout exceeded once in T years.

What varies naturally is kept apart from what is not known. Where stops above a limit go undetected,
the records hold a share P(seen | V) of the avalanches of volume V: λ(V) = λ_seen(V) / P(seen | V)
came, by the friction of the model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.special import ndtr

from avahazard.arrays import Bools, Floats, Ints
from avahazard.effects.site import Site, release_place
from avahazard.hazard.exceedance_kernel import (
    REACH,
    Descent,
    ShareCurves,
    exceeded_places,
    rates_at,
    tabulate,
)
from avahazard.hazard.extremes import EventVolumes, annual_rate
from avahazard.inference.model.friction_model import below
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.cells import Resistance
from avahazard.physics.runout_curve import MU, RunoutCurve, inverse

LEAST_SCATTER = 1e-9
PER_SCATTER = 5.0
"""Nodes of a curve of shares to its smallest scatter."""
MAX_NODES = 1024
"""Curves that need more are not tabulated: every share is then summed anew."""
NOTHING = 1e-8
"""A share of avalanches that does not count."""
HALVINGS = 24


@dataclass(frozen=True, eq=False)
class Avalanches:
    """Avalanches of one path: classes of release and columns, volumes, and posterior draws.

    Of `volumes.rate` `[n_parameters]` avalanches a year `class_share` `[n_classes]` are of each
    class, and `kind_share` `[n_parameters, n_kinds]` of each kind that nobody records, whatever the
    volume. Friction has `location` (log μ, or μ where it is normal) and `scatter`, both
    `[n_parameters, n_classes, n_nodes]`: the nodes are the volumes of one kind after the other,
    of which each has its `share` `[n_parameters, n_nodes]`. Path offsets are in them. Draw p runs
    by `curves[group[p]]`, of which row c is that of class c; `ahead` `[n_groups][n_classes]` is
    how far (m) the front is ahead of the block.
    `sigma_m` `[n_parameters]`: the stops scatter in metres instead (metropolis).
    """

    site: Site
    release: Ints
    volumes: EventVolumes
    class_share: Floats
    kind_share: Floats
    location: Floats
    scatter: Floats
    group: Ints
    curves: tuple[RunoutCurve, ...]
    resistances: tuple[Resistance, ...]
    ahead: tuple[Floats, ...]
    in_log: bool
    student: bool
    sigma_m: Floats | None

    @property
    def n_parameters(self) -> int:
        """Number of posterior draws."""
        return len(self.location)

    @property
    def n_classes(self) -> int:
        """Number of classes of release and columns."""
        return len(self.class_share)

    @property
    def share(self) -> Floats:
        """Share of the avalanches of each volume and kind, `[n_parameters, n_nodes]`."""
        each = self.kind_share[:, :, None] * self.volumes.share[:, None]
        return np.asarray(each.reshape(len(each), -1))

    @cached_property
    def descent(self) -> Descent:
        """The same as the kernels take it."""
        falling, discontinuous, ends = stops(self.curves)
        shares, kind = friction_shares(self, ends)
        return Descent(
            falling=falling,
            discontinuous=discontinuous,
            group=self.group,
            class_share=self.class_share,
            rate=self.volumes.rate,
            kind=kind,
            shares=shares,
            in_log=self.in_log,
        )

    def of_draws(self, of: Callable[[Floats], Floats], group: Ints) -> Avalanches:
        """The same with other draws: `of` makes each array `[n_parameters, …]` of that of these."""
        rate, share = of(self.volumes.rate), of(self.volumes.share)
        return replace(
            self,
            volumes=replace(self.volumes, rate=rate, share=share),
            kind_share=of(self.kind_share),
            location=of(self.location),
            scatter=of(self.scatter),
            group=group,
            sigma_m=None if self.sigma_m is None else of(self.sigma_m),
        )


def friction_below(avalanches: Avalanches, mu: Floats) -> Floats:
    """Chance that the friction of an avalanche lies under `mu`.

    `mu` is of any shape that goes with `[n_parameters, n_classes, n_nodes]`, as is the chance;
    friction that is normal is taken given that it is over 0.
    """
    scatter, mu = np.maximum(avalanches.scatter, LEAST_SCATTER), np.maximum(mu, 0.0)
    if avalanches.in_log:
        with np.errstate(divide="ignore"):
            return below((np.log(mu) - avalanches.location) / scatter, avalanches.student)
    impossible = below(-avalanches.location / scatter, avalanches.student)
    under = below((mu - avalanches.location) / scatter, avalanches.student)
    return np.asarray((under - impossible) / np.maximum(1.0 - impossible, 1e-300))


def yearly_rate(avalanches: Avalanches, chance: Floats) -> Floats:
    """Yearly rate `[n_parameters]` by the `chance` `[n_parameters, n_classes, n_nodes]`."""
    by_class = np.einsum("pcv,pv->pc", chance, avalanches.share)
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


SAMPLED_PLACES = 4001
QUANTILES = (0.05, 0.5, 0.95)


def rates_past(avalanches: Avalanches, x: Floats) -> Floats:
    """Yearly rates `[n_places, n_parameters]` of what stops beyond places x (m), or leaves."""
    if avalanches.sigma_m is None:
        return np.asarray(rates_at(avalanches.descent, np.ascontiguousarray(x, np.float64)))
    rate = _rate_in_metres(avalanches)
    return np.array([rate(np.full(avalanches.n_parameters, place)) for place in x])


def places_passed(avalanches: Avalanches, rate: Floats | float) -> Floats:
    """The x (m) `[n_parameters]` that is passed at a yearly `rate`.

    `rate` is `[n_parameters]` or one for all; of one draw, `[n]` for as many places. inf where even
    the end of the profile is passed more often, the highest release where that is less often.
    """
    ends = path_ends(avalanches)
    if avalanches.sigma_m is None:
        levels = rate * np.ones(avalanches.n_parameters)
        return np.asarray(exceeded_places(avalanches.descent, levels, *ends, HALVINGS))
    n = max(avalanches.n_parameters, np.size(rate))
    return exceeded(_rate_in_metres(avalanches), rate, *ends, n)


def path_ends(avalanches: Avalanches) -> tuple[float, float]:
    """The highest release and the end of the profile, x in m."""
    return float(avalanches.site.release_x.min()), float(avalanches.site.smooth.x_max)


def friction_shares(avalanches: Avalanches, ends: tuple[float, float]) -> tuple[ShareCurves, Ints]:
    """Shares with friction under ν between two frictions, and the kind of each class."""
    student = avalanches.student
    first, kind = _kinds(avalanches)
    location = np.ascontiguousarray(avalanches.location[:, first])
    scatter = np.ascontiguousarray(np.maximum(avalanches.scatter, LEAST_SCATTER)[:, first])
    share = np.where(avalanches.share < NOTHING, 0.0, avalanches.share)
    weight = np.broadcast_to(share[:, None], location.shape).copy()
    none = np.zeros(location.shape[:2])
    if avalanches.in_log:
        ends = float(np.log(ends[0])), float(np.log(ends[1]))
    else:
        impossible = below(-location / scatter, student)
        weight /= np.maximum(1.0 - impossible, 1e-300)
        none = np.sum(weight * impossible, axis=2)
    far = np.inf if student else REACH
    low = np.maximum(np.min(location - far * scatter, axis=2), ends[0])
    high = np.minimum(np.max(location + far * scatter, axis=2), ends[1])
    step = np.min(scatter, axis=2) / PER_SCATTER
    n_nodes = np.maximum(np.ceil(np.maximum(high - low, 0.0) / step) + 1.0, 2.0)
    whole = int(min(n_nodes.max(), MAX_NODES + 1))
    nodes = np.zeros((*low.shape, 0 if whole > MAX_NODES else whole, 3))
    n_nodes = np.minimum(n_nodes, whole).astype(np.int64)
    shares = ShareCurves(location, scatter, weight, none, low, 1.0 / step, n_nodes, nodes, student)
    if nodes.size:
        tabulate(shares)
    return shares, kind


@lru_cache(maxsize=4)
def stops(curves: tuple[RunoutCurve, ...]) -> tuple[Floats, Bools, tuple[float, float]]:
    """`falling` and `discontinuous` of `Descent`, and the ends of the frictions that are asked for.

    Of the last curves they are kept: every row of a path takes the same.
    """
    # Rounding may lift a value by an ulp over that of a lower friction.
    falling = np.array(
        [np.minimum.accumulate(np.where(c.left, np.inf, c.x), axis=1) for c in curves]
    )
    return falling, np.array([c.discontinuous for c in curves]), _thresholds_between(falling)


def _thresholds_between(falling: Floats) -> tuple[float, float]:
    """The ends of the frictions under which a block passes places where some stop."""
    left = np.sum(np.isinf(falling), axis=2).min()
    held = np.argmax(falling <= falling[:, :, -1:], axis=2).max()
    return float(MU[max(int(left) - 1, 0)]), float(MU[int(held)])


def _kinds(avalanches: Avalanches) -> tuple[Ints, Ints]:
    """A class of each kind of friction `[n_kinds]`, and the kind of each class `[n_classes]`."""
    location, scatter = avalanches.location, avalanches.scatter
    rows = np.hstack([location[0], scatter[0]])
    _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    kind = kind.ravel()
    alike = first[kind]
    if np.array_equal(location, location[:, alike]) and np.array_equal(scatter, scatter[:, alike]):
        return first, kind
    every = np.arange(avalanches.n_classes)
    return every, every


def _rate_in_metres(avalanches: Avalanches) -> Callable[[Floats], Floats]:
    """Yearly rates past x `[n_parameters]` where stops scatter by metres of elevation."""
    chance = exceedance_in_metres(avalanches)
    return lambda x: yearly_rate(avalanches, chance(x))


def exceedance_in_metres(avalanches: Avalanches) -> Callable[[Floats], Floats]:
    """Chances `[n_parameters, n_classes, n_nodes]` to stop beyond x `[n_parameters]`.

    Stops are at the block's elevation + sigma z, at the first place so low (`scattered_stops`).
    """
    assert avalanches.sigma_m is not None
    smooth = avalanches.site.smooth
    x = np.linspace(smooth.x_min, smooth.x_max, SAMPLED_PLACES)
    lowest = np.minimum.accumulate(smooth.height(x))
    # On a counter-slope nothing stops: what is below the floor lies on it.
    floor = x[np.argmin(lowest)] if np.argmin(lowest) < len(x) - 1 else np.inf
    stop = _stop_elevation(avalanches)
    sigma = avalanches.sigma_m[:, None, None]

    def chance(place: Floats) -> Floats:
        height = np.interp(place, x, lowest)[:, None, None]
        stays = place[:, None, None] >= floor
        with np.errstate(invalid="ignore"):
            passes = ndtr((height - stop) / sigma)
        return np.where(np.isneginf(stop), 1.0, np.where(stays, 0.0, passes))

    return chance


def _stop_elevation(avalanches: Avalanches) -> Floats:
    """Elevation of the block's stop at the friction of each volume, -inf where it left."""
    mu = np.exp(avalanches.location) if avalanches.in_log else avalanches.location
    result = np.empty_like(mu)
    for g, curve in enumerate(avalanches.curves):
        selected = np.flatnonzero(avalanches.group == g)
        for c in range(avalanches.n_classes):
            _, height, status = curve[c].at(mu[selected, c].ravel())
            found = np.where(status == LEFT_PROFILE, -np.inf, height)
            result[selected, c] = found.reshape(len(selected), -1)
    return result


N_LEVELS = 199
"""Probabilities at which the natural variability is followed."""
N_PLACES = 60


def exceeded_runout(avalanches: Avalanches, return_period_years: float) -> Floats:
    """x (m) `[n_parameters]` that a year's avalanches pass with chance 1/T; inf past the end.

    All volumes, frictions and releases are mixed, at the rate of the path, within each draw of
    the parameters: λ P(X > x) = -log(1 - 1/T).
    """
    return places_passed(avalanches, annual_rate(return_period_years))


def middle_runout(avalanches: Avalanches) -> Floats:
    """The median runout x (m) `[n_parameters]` of the avalanches of each draw of the parameters."""
    return places_passed(avalanches, 0.5 * avalanches.volumes.rate)


def natural_runouts(avalanches: Avalanches) -> Floats:
    """Runouts x (m) `[n_levels]` at even probabilities, all parameters at their middle."""
    middle = at_the_middle(avalanches)
    level = 1.0 - (np.arange(N_LEVELS) + 0.5) / N_LEVELS
    return places_passed(middle, level * middle.volumes.rate)


def reach(
    avalanches: Avalanches,
    n_places: int = N_PLACES,
    rates: Callable[[Floats], Floats] | None = None,
) -> tuple[Floats, Floats]:
    """Places x (m) `[n_places]`, and the annual chance that one or more avalanches pass each.

    x runs evenly from the highest release to the end of the profile. The chance
    1 - exp(-λ P(X > x)) is `[3, n_places]`, 5, 50 and 95 % over the uncertainty of the parameters.
    `rates(x)` `[n_places, n_parameters]` are those of an average over models.
    """
    x = np.linspace(*path_ends(avalanches), n_places)
    often = rates_past(avalanches, x) if rates is None else rates(x)
    return x, np.quantile(-np.expm1(-often), QUANTILES, axis=1)


def at_volume(avalanches: Avalanches, log_volume: Floats) -> Avalanches:
    """The same path with one volume for each draw (log m3) `[n_parameters]`, once a year."""
    nodes = avalanches.volumes.log_volume
    n = avalanches.n_parameters
    place = np.interp(log_volume, nodes, np.arange(len(nodes)))
    k = np.minimum(place.astype(np.int64), max(len(nodes) - 2, 0))
    part, draw = place - k, np.arange(n)

    def between(values: Floats) -> Floats:
        values = values.reshape(n, avalanches.n_classes, -1, len(nodes))
        after = values[draw, :, :, np.minimum(k + 1, len(nodes) - 1)] * part[:, None, None]
        return np.asarray(values[draw, :, :, k] * (1 - part)[:, None, None] + after)

    volumes = EventVolumes(np.ones(n), np.zeros(1), np.ones((n, 1)))
    location, scatter = between(avalanches.location), between(avalanches.scatter)
    return replace(avalanches, volumes=volumes, location=location, scatter=scatter)


def at_the_middle(avalanches: Avalanches) -> Avalanches:
    """The same path with one draw: rate, shares, friction and tables at their medians."""
    group = avalanches.group[[avalanches.n_parameters // 2]]
    one = avalanches.of_draws(lambda values: np.median(values, axis=0, keepdims=True), group)
    share = one.volumes.share / one.volumes.share.sum(axis=1, keepdims=True)
    return replace(one, volumes=replace(one.volumes, share=share))


LEAST_SEEN = 0.05
"""Volumes that are seen less often count as if they were seen so often: few records say more."""


def with_unseen(avalanches: Avalanches, limit: Floats) -> Avalanches:
    """The same with the avalanches that stopped above `limit` (m) `[n_groups]`, nan: none."""
    volumes = avalanches.volumes
    if not volumes.seen_only or np.isnan(limit).all():
        return avalanches
    share = volumes.share / np.maximum(chance_seen(avalanches, limit), LEAST_SEEN)
    whole = share.sum(axis=1)
    share /= whole[:, None]
    every = EventVolumes(volumes.rate * whole, volumes.log_volume, share)
    return replace(avalanches, volumes=every)


def chance_seen(avalanches: Avalanches, limit: Floats) -> Floats:
    """Chance `[n_parameters, n_volumes]` to stop below `limit` (m) `[n_groups]`, or leave."""
    smooth = avalanches.site.smooth
    place = np.array([smooth.x_min if np.isnan(z) else release_place(smooth, z) for z in limit])
    if avalanches.sigma_m is not None:
        chance = exceedance_in_metres(avalanches)(place[avalanches.group])
    else:
        falling, discontinuous, _ = stops(avalanches.curves)
        mu = [
            [np.inf if np.isnan(z) else inverse(curve, gap, x) for curve, gap in rows]
            for z, x, rows in zip(limit, place, map(zip, falling, discontinuous), strict=True)
        ]
        chance = friction_below(avalanches, np.array(mu)[avalanches.group][:, :, None])
    by_node = np.einsum("pcv,c->pv", chance, avalanches.class_share)
    by_kind = by_node.reshape(*avalanches.kind_share.shape, -1)
    return np.asarray(np.einsum("pkv,pk->pv", by_kind, avalanches.kind_share))
