"""Yearly rates past places, and places passed at a rate, draw by draw."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.hazard.share_curves import ShareCurves, share_under
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import friction_after, n_over

RARE = 1e-9
"""Rates under this part of the wanted one are far from it, whatever they are."""
FIRST_HALVINGS = 6
"""Of all draws these meet the same places, whose frictions are looked up once."""


class Descent(NamedTuple):
    """`Avalanches` as the kernels take them.

    `falling` `[n_groups, n_classes, n_friction]`: x of the stops (inf where the profile was left);
    `broken` `[n_groups, n_classes, n_friction - 1]` as in `RunoutCurve`; `group`, `rate`
    `[n_parameters]`; `class_share`, `kind` `[n_classes]`, the kind of friction in `shares`.
    """

    falling: Floats
    broken: NDArray[np.bool_]
    group: NDArray[np.int64]
    class_share: Floats
    rate: Floats
    kind: NDArray[np.int64]
    shares: ShareCurves
    in_log: bool


@kernel
def rates_at(descent, x):  # type: ignore[no-untyped-def]
    """Rates `[n_places, n_parameters]` of what stops beyond places x (m) `[n_places]`."""
    nu, over = _room(descent, x)
    result = np.empty((len(x), len(descent.rate)))
    _fill_rates(descent, x, nu, over, result)
    return result


@kernel(inner=True)
def _fill_rates(descent, x, nu, over, result):  # type: ignore[no-untyped-def]
    _thresholds(descent, x, nu, over)
    for p in range(len(descent.rate)):
        for i in range(len(x)):
            result[i, p] = _rate_under(descent, p, nu[i, descent.group[p]])


@kernel(inner=True)
def _room(descent, x):  # type: ignore[no-untyped-def]
    """Memory for `_thresholds`, both `[n_places, n_groups, n_classes]`."""
    n_groups, n_classes, _ = descent.falling.shape
    nu = np.empty((len(x), n_groups, n_classes))
    return nu, np.empty(nu.shape, np.int64)


@kernel(inner=True)
def _thresholds(descent, x, nu, over):  # type: ignore[no-untyped-def]
    """ν under which blocks stop beyond places x, and how many nodes of their curves do."""
    n_groups, n_classes, n = descent.falling.shape
    for i in range(len(x)):
        for g in range(n_groups):
            for c in range(n_classes):
                over[i, g, c] = n_over(descent.falling[g, c], x[i], 0, n)
                nu[i, g, c] = _threshold(descent, g, c, x[i], over[i, g, c])


@kernel(inner=True, forceinline=True)
def _threshold(descent, g, c, x, over):  # type: ignore[no-untyped-def]
    """ν under which a block of group g and class c stops beyond x; -inf never, inf always."""
    mu = friction_after(descent.falling[g, c], descent.broken[g, c], x, over)
    if mu <= 0.0:
        return -np.inf
    return math.log(mu) if descent.in_log else mu


@kernel(inner=True, forceinline=True)
def _share(descent, p, c, nu):  # type: ignore[no-untyped-def]
    if nu == -np.inf:
        return 0.0
    if nu == np.inf:
        return 1.0
    return share_under(descent.shares, p, descent.kind[c], nu)


@kernel(inner=True, forceinline=True)
def _rate_under(descent, p, nu):  # type: ignore[no-untyped-def]
    """The rate of draw p with friction under ν `[n_classes]`."""
    total = 0.0
    for c in range(len(nu)):
        total += descent.class_share[c] * _share(descent, p, c, nu[c])
    return descent.rate[p] * total


@kernel(inner=True, forceinline=True)
def _height(rate, wanted):  # type: ignore[no-untyped-def]
    """log of a rate over the wanted one, not far below nought."""
    return math.log(max(rate / wanted, RARE))


@kernel(inner=True, forceinline=True)
def _height_at(descent, p, x, wanted, least, most):  # type: ignore[no-untyped-def]
    """`_height` past x, where from `least` to `most` `[n_classes]` nodes of the curves stop."""
    g, total = descent.group[p], 0.0
    for c in range(len(least)):
        over = n_over(descent.falling[g, c], x, least[c], most[c])
        nu = _threshold(descent, g, c, x, over)
        total += descent.class_share[c] * _share(descent, p, c, nu)
    return _height(descent.rate[p] * total, wanted)


@kernel
def exceeded_places(descent, wanted, low, high, halvings):  # type: ignore[no-untyped-def]
    """x (m) `[n_parameters]` passed at the rates `wanted` `[n_parameters]`, or `[n]` of one draw.

    As `avalanches.exceeded`, bit for bit: the same cell of the same halvings. But the first of them
    take frictions that are looked up once, then the place is enclosed by the ITP method (Oliveira &
    Takahashi 2020), which needs a third of the rates, and only a halving that this leaves open
    takes one more.
    """
    x = _halved(low, high)
    nu, over = _room(descent, x)
    result = np.empty(len(wanted))
    _fill_places(descent, wanted, low, halvings, x, nu, over, result)
    return result


@kernel(inner=True)
def _fill_places(descent, wanted, low, halvings, x, table, over, result):  # type: ignore[no-untyped-def]
    _thresholds(descent, x, table, over)
    for i in range(len(wanted)):
        p = i if len(descent.rate) > 1 else 0
        g = descent.group[p]
        a, b = 0, len(x) - 1
        at_b = _height(_rate_under(descent, p, table[b, g]), wanted[i])
        if at_b >= 0.0:
            result[i] = np.inf
            continue
        at_a = _height(_rate_under(descent, p, table[a, g]), wanted[i])
        if at_a < 0.0:
            result[i] = low
            continue
        while b - a > 1:
            middle = (a + b) // 2
            found = _height(_rate_under(descent, p, table[middle, g]), wanted[i])
            if found >= 0.0:
                a, at_a = middle, found
            else:
                b, at_b = middle, found
        least, most = over[b, g], over[a, g]
        bottom, top = x[a], x[b]
        left = halvings - FIRST_HALVINGS
        before, after = _enclosed(descent, p, wanted[i], least, most, bottom, top, at_a, at_b, left)
        for _ in range(left):
            place = 0.5 * (bottom + top)
            often = place <= before
            if before < place < after:
                often = _height_at(descent, p, place, wanted[i], least, most) >= 0.0
                if often:
                    before = place
                else:
                    after = place
            if often:
                bottom = place
            else:
                top = place
        # Nothing was ever often enough: the lowest level itself.
        result[i] = low if bottom == low else 0.5 * (bottom + top)


@kernel(inner=True)
def _halved(low, high):  # type: ignore[no-untyped-def]
    """The places that the first halvings meet, in their order along the path."""
    n = 2**FIRST_HALVINGS
    x = np.empty(n + 1)
    x[0], x[n] = low, high
    while n > 1:
        for k in range(0, len(x) - 1, n):
            x[k + n // 2] = 0.5 * (x[k] + x[k + n])
        n //= 2
    return x


@kernel(inner=True, forceinline=True)
def _enclosed(descent, p, wanted, least, most, a, b, at_a, at_b, halvings):  # type: ignore[no-untyped-def]
    """Two places a cell of the halvings apart, or nearer, between which the rate is the wanted."""
    tolerance = (b - a) / 2.0**halvings
    steps = halvings + 1
    slowing = 0.2 / (b - a)
    for j in range(steps + 1):
        if b - a <= tolerance:
            break
        half = 0.5 * (a + b)
        secant = (at_a * b - at_b * a) / (at_a - at_b)
        towards = 1.0 if half >= secant else -1.0
        shift = slowing * (b - a) * (b - a)
        place = secant + towards * shift if shift <= abs(half - secant) else half
        room = 0.5 * tolerance * 2.0 ** (steps - j) - 0.5 * (b - a)
        if abs(place - half) > room:
            place = half - towards * room
        found = _height_at(descent, p, place, wanted, least, most)
        if found >= 0.0:
            a, at_a = place, found
        else:
            b, at_b = place, found
    return a, b
