"""Speeds along a path that are exceeded once in T years, by posterior draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.hazard.avalanches import Avalanches, annual_rate, friction_below
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import MU

N_NODES = 128
REACH, STUDENT_REACH = 6.0, 16.0
"""How far the curves go, in scatters from the location: beyond is under 1e-5 of avalanches."""
LEAST_WIDTH = 1e-8
LEAST_RATE = 1e-30


@dataclass(frozen=True, slots=True, eq=False)
class RateCurves:
    """Log yearly rate `[n_parameters, n_classes, N_NODES]` of avalanches with friction under μ.

    Node k lies at log μ = `low` + k `step`, both `[n_parameters, n_classes]`; below the first node
    the rate is nought, above the last it is that of the last.
    """

    low: Floats
    step: Floats
    log_rate: Floats


def rate_curves(avalanches: Avalanches) -> RateCurves:
    """Tabulate the rates of each posterior draw and class, where their frictions lie.

    The range is cut to the frictions that the block is run for.
    """
    if avalanches.n_classes > 1 and _alike(avalanches.location) and _alike(avalanches.scatter):
        # Classes that differ by their release alone share their friction.
        first = replace(
            avalanches,
            location=avalanches.location[:, :1],
            scatter=avalanches.scatter[:, :1],
            class_share=np.ones(1),
        )
        one = rate_curves(first)
        shares = np.log(avalanches.class_share)[:, None]
        n = avalanches.n_classes
        return RateCurves(
            np.repeat(one.low, n, axis=1), np.repeat(one.step, n, axis=1), one.log_rate + shares
        )
    reach = STUDENT_REACH if avalanches.student else REACH
    low = np.min(avalanches.location - reach * avalanches.scatter, axis=2)
    high = np.max(avalanches.location + reach * avalanches.scatter, axis=2)
    if not avalanches.in_log:
        low, high = np.log(np.maximum(low, MU[0])), np.log(np.maximum(high, MU[0]))
    low = np.clip(low - LEAST_WIDTH, np.log(MU[0]), np.log(MU[-1]))
    high = np.maximum(np.minimum(high + LEAST_WIDTH, np.log(MU[-1])), low + LEAST_WIDTH)
    step = (high - low) / (N_NODES - 1)
    rates = np.empty((*low.shape, N_NODES))
    for k in range(N_NODES):
        chance = friction_below(avalanches, np.exp(low + k * step))
        rates[:, :, k] = np.einsum("pcv,pv->pc", chance, avalanches.volumes.share)
    rates *= avalanches.volumes.rate[:, None, None] * avalanches.class_share[:, None]
    return RateCurves(low, step, np.log(np.maximum(rates, LEAST_RATE)))


def _alike(values: Floats) -> bool:
    """Whether all classes of `[n_parameters, n_classes, n_volumes]` have the same."""
    return bool(np.array_equal(values, np.broadcast_to(values[:, :1], values.shape)))


HALVINGS = 16
"""Of squared speed: 0.1 m/s or less at the slowest that matter."""


def exceeded_speeds(avalanches: Avalanches, x: Floats, return_periods: Sequence[float]) -> Floats:
    """Speed (m/s) at places x (m) `[n_places]` that a year's fastest exceeds with chance 1/T.

    `[n_periods, n_parameters, n_places]`, T rising; 0 where avalanches come less often.

    With u(x; μ) the speed of the block, which falls as μ rises, the yearly rate of avalanches
    faster than s is Σ over classes of the rate of those with friction under the μ of u(x; μ) = s;
    the result is the s at which that rate is -log(1 - 1/T).
    """
    curves = rate_curves(avalanches)
    rates = np.array([annual_rate(period) for period in sorted(return_periods)])
    result = np.zeros((len(rates), avalanches.n_parameters, len(x)))
    for g in range(len(avalanches.resistances)):
        mine = np.flatnonzero(avalanches.group == g)
        if len(mine):
            result[:, mine] = _of_group(_squares(avalanches, g, x), curves, mine, rates)
    return result


def _squares(avalanches: Avalanches, group: int, x: Floats) -> Floats:
    """Squared speeds with which the front passes x, `[n_classes, n_places, n_mu]`.

    For each class and friction of `MU`, those of the block where it is then.
    """
    kinds: dict[tuple[int, float], Floats] = {}
    cells = avalanches.site.cells(avalanches.resistances[group])
    for release, ahead in zip(avalanches.release, avalanches.ahead[group], strict=True):
        kind = (int(release), float(ahead))
        if kind not in kinds:
            release_x = float(avalanches.site.release_x[release])
            place = _behind(avalanches.site, x, float(ahead))
            kinds[kind] = avalanches.site.speeds(cells, release_x, place).T ** 2
    squares = [
        kinds[int(release), float(ahead)]
        for release, ahead in zip(avalanches.release, avalanches.ahead[group], strict=True)
    ]
    # Rounding may lift a speed by an ulp over that of a lower friction.
    return np.ascontiguousarray(np.minimum.accumulate(np.array(squares), axis=2))


def _behind(site: Site, x: Floats, distance: float) -> Floats:
    """x of the places `distance` metres along the path before x; above the top it goes on."""
    if distance == 0.0:
        return x
    terrain = site.terrain
    s = np.interp(x, terrain.x, terrain.s) - distance
    return np.asarray(np.interp(s, terrain.s, terrain.x) + np.minimum(s, 0.0))


def _of_group(
    squares: Floats, curves: RateCurves, mine: NDArray[np.int64], rates: Floats
) -> Floats:
    found = _exceeded(
        squares, curves.low[mine], curves.step[mine], curves.log_rate[mine], rates, MU
    )
    return np.asarray(found)


@kernel
def _exceeded(squares, low, step, log_rate, rates, mu):  # type: ignore[no-untyped-def]
    n_parameters, n_places = len(low), squares.shape[1]
    result = np.zeros((len(rates), n_parameters, n_places))
    for p in range(n_parameters):
        for i in range(n_places):
            fastest = squares[:, i, 0].max()
            bottom = 0.0
            for t in range(len(rates)):
                # Longer periods, higher speeds: each starts from the one before.
                top = fastest
                passing = _rate_over(squares, i, 0.0, low[p], step[p], log_rate[p], mu)
                if passing < rates[t]:
                    continue
                for _ in range(HALVINGS):
                    middle = 0.5 * (bottom + top)
                    rate = _rate_over(squares, i, middle, low[p], step[p], log_rate[p], mu)
                    if rate >= rates[t]:
                        bottom = middle
                    else:
                        top = middle
                result[t, p, i] = np.sqrt(0.5 * (bottom + top))
    return result


@kernel
def _rate_over(squares, i, square, low, step, log_rate, mu):  # type: ignore[no-untyped-def]
    """Yearly rate of avalanches whose squared speed at place i is over `square`."""
    total = 0.0
    last = log_rate.shape[1] - 1
    for c in range(len(low)):
        falling = squares[c, i]
        # The first friction of the grid that does not exceed the level.
        first, end = 0, len(falling)
        while first < end:
            middle = (first + end) // 2
            if falling[middle] > square:
                first = middle + 1
            else:
                end = middle
        if first == 0:
            continue
        t = float(last)
        if first < len(falling):
            above, below = falling[first - 1], falling[first]
            if below == 0.0 and first > 1:
                # The block stops on the way to that friction: carried on from the cell before.
                below = min(2.0 * above - falling[first - 2], 0.0)
            part = (above - square) / (above - below)
            friction = mu[first - 1] + part * (mu[first] - mu[first - 1])
            t = (np.log(friction) - low[c]) / step[c]
        if t > 0.0:
            k = min(int(t), last - 1)
            part = min(t - k, 1.0)
            total += np.exp(log_rate[c, k] * (1.0 - part) + log_rate[c, k + 1] * part)
    return total
