"""Speeds along a path that are exceeded once in T years, by posterior draw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.hazard.avalanches import Avalanches, annual_rate
from avahazard.hazard.exceedance import friction_shares
from avahazard.hazard.passing_kernel import share_under
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import MU

LEAST_RATE = 1e-30
STEEP = 0.05
"""Change of a share from one friction to the next that is straight enough between them."""
HALVINGS = 16
"""Of squared speed: 0.1 m/s or less at the slowest that matter."""


def exceeded_speeds(avalanches: Avalanches, x: Floats, return_periods: Sequence[float]) -> Floats:
    """Speed (m/s) at places x (m) `[n_places]` that a year's fastest exceeds with chance 1/T.

    `[n_periods, n_parameters, n_places]`, T rising; 0 where avalanches come less often.

    With u(x; μ) the speed of the block, which falls as μ rises, the yearly rate of avalanches
    faster than s is Σ over classes of the rate of those with friction under the μ of u(x; μ) = s;
    the result is the s at which that rate is -log(1 - 1/T).
    """
    shares, kind = friction_shares(avalanches, (float(MU[0]), float(MU[-1])))
    wanted = np.array([annual_rate(period) for period in sorted(return_periods)])
    wanted = wanted[:, None] / np.maximum(avalanches.volumes.rate, LEAST_RATE)
    result = np.zeros((*wanted.shape, len(x)))
    of_classes = shares, kind, avalanches.class_share
    nu = np.log(MU) if avalanches.in_log else MU
    for g in range(len(avalanches.resistances)):
        mine = np.flatnonzero(avalanches.group == g)
        if len(mine):
            squares = _squares(avalanches, g, x)
            _exceeded(squares, *of_classes, mine, wanted, nu, result)
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


@kernel
def _exceeded(squares, shares, kind, class_share, draws, wanted, nu, result):  # type: ignore[no-untyped-def]
    """Fill in the speeds of some `draws` that the shares `wanted` `[n_periods, …]` exceed.

    `nu` `[n_mu]` are the frictions of `squares`, or their logs, as `shares` take them.
    """
    under = np.empty((shares.low.shape[1], len(nu)))
    for p in draws:
        for k in range(len(under)):
            for j in range(len(nu)):
                under[k, j] = share_under(shares, p, k, nu[j])
        for i in range(squares.shape[1]):
            fastest = squares[:, i, 0].max()
            bottom = 0.0
            for t in range(len(wanted)):
                # Longer periods, higher speeds: each starts from the one before.
                top = fastest
                moving = _share_over(squares, i, 0.0, under, shares, kind, class_share, p, nu)
                if moving < wanted[t, p]:
                    continue
                for _ in range(HALVINGS):
                    middle = 0.5 * (bottom + top)
                    share = _share_over(squares, i, middle, under, shares, kind, class_share, p, nu)
                    if share >= wanted[t, p]:
                        bottom = middle
                    else:
                        top = middle
                result[t, p, i] = np.sqrt(0.5 * (bottom + top))


@kernel(inner=True, forceinline=True)
def _share_over(squares, i, square, under, shares, kind, class_share, p, nu):  # type: ignore[no-untyped-def]
    """Share of the avalanches of draw p whose squared speed at place i is over `square`.

    `under` `[n_kinds, n_mu]` are its shares with friction under each of `nu`.
    """
    total = 0.0
    for c in range(len(kind)):
        falling, k = squares[c, i], kind[c]
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
        if first == len(falling):
            total += class_share[c] * under[k, first - 1]
            continue
        above, below = falling[first - 1], falling[first]
        if below == 0.0 and first > 1:
            # The block stops on the way to that friction: carried on from the cell before.
            below = min(2.0 * above - falling[first - 2], 0.0)
        part = (above - square) / (above - below)
        share = under[k, first - 1] + part * (under[k, first] - under[k, first - 1])
        if under[k, first] - under[k, first - 1] > STEEP:
            share = share_under(shares, p, k, nu[first - 1] + part * (nu[first] - nu[first - 1]))
        total += class_share[c] * share
    return total
