"""Yearly rates past places, and places passed at a rate, draw by draw."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.hazard.share_curves import ShareCurves, share_under
from avahazard.kernels import kernel
from avahazard.physics.runout_curve import inverse

RARE = 1e-9
"""Rates under this part of the wanted one are far from it, whatever they are."""


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
    n_groups, n_classes, _ = descent.falling.shape
    result = np.zeros((len(x), len(descent.rate)))
    nu = np.empty((n_groups, n_classes))
    for i in range(len(x)):
        for g in range(n_groups):
            for c in range(n_classes):
                nu[g, c] = _threshold(descent, g, c, x[i])
        for p in range(len(descent.rate)):
            for c in range(n_classes):
                result[i, p] += descent.class_share[c] * _share(
                    descent, p, c, nu[descent.group[p], c]
                )
            result[i, p] *= descent.rate[p]
    return result


@kernel(forceinline=True)
def _threshold(descent, g, c, x):  # type: ignore[no-untyped-def]
    """ν under which a block of group g and class c stops beyond x; -inf never, inf always."""
    mu = inverse(descent.falling[g, c], descent.broken[g, c], x)
    if mu <= 0.0:
        return -np.inf
    return math.log(mu) if descent.in_log else mu


@kernel(forceinline=True)
def _share(descent, p, c, nu):  # type: ignore[no-untyped-def]
    if nu == -np.inf:
        return 0.0
    if nu == np.inf:
        return 1.0
    return share_under(descent.shares, p, descent.kind[c], nu)


@kernel(forceinline=True)
def _rate(descent, p, x):  # type: ignore[no-untyped-def]
    """The rate of draw p past x."""
    total = 0.0
    for c in range(len(descent.class_share)):
        nu = _threshold(descent, descent.group[p], c, x)
        total += descent.class_share[c] * _share(descent, p, c, nu)
    return descent.rate[p] * total


@kernel(forceinline=True)
def _height(descent, p, x, wanted):  # type: ignore[no-untyped-def]
    """log of the rate past x over the wanted one, not far below nought."""
    return math.log(max(_rate(descent, p, x) / wanted, RARE))


@kernel
def exceeded_places(descent, wanted, low, high, halvings):  # type: ignore[no-untyped-def]
    """x (m) `[n_parameters]` passed at the rates `wanted` `[n_parameters]`.

    As `avalanches.exceeded`, bit for bit: the same cell of the same halvings. But the place is
    first enclosed by the ITP method (Oliveira & Takahashi 2020), which needs a third of the rates,
    and only a halving that this leaves open takes one more.
    """
    result = np.empty(len(wanted))
    for p in range(len(wanted)):
        at_high = _height(descent, p, high, wanted[p])
        if at_high >= 0.0:
            result[p] = np.inf
            continue
        at_low = _height(descent, p, low, wanted[p])
        if at_low < 0.0:
            result[p] = low
            continue
        before, after = _enclosed(descent, p, wanted[p], low, high, at_low, at_high, halvings)
        bottom, top = low, high
        for _ in range(halvings):
            middle = 0.5 * (bottom + top)
            often = middle <= before
            if before < middle < after:
                often = _height(descent, p, middle, wanted[p]) >= 0.0
                if often:
                    before = middle
                else:
                    after = middle
            if often:
                bottom = middle
            else:
                top = middle
        # Nothing was ever often enough: the lowest level itself.
        result[p] = low if bottom == low else 0.5 * (bottom + top)
    return result


@kernel(forceinline=True)
def _enclosed(descent, p, wanted, a, b, at_a, at_b, halvings):  # type: ignore[no-untyped-def]
    """Two places a cell of the halvings apart, or nearer, between which the rate is the wanted."""
    tolerance = (b - a) / 2.0**halvings
    most = halvings + 1
    slowing = 0.2 / (b - a)
    for j in range(most + 1):
        if b - a <= tolerance:
            break
        half = 0.5 * (a + b)
        secant = (at_a * b - at_b * a) / (at_a - at_b)
        towards = 1.0 if half >= secant else -1.0
        shift = slowing * (b - a) * (b - a)
        place = secant + towards * shift if shift <= abs(half - secant) else half
        room = 0.5 * tolerance * 2.0 ** (most - j) - 0.5 * (b - a)
        if abs(place - half) > room:
            place = half - towards * room
        found = _height(descent, p, place, wanted)
        if found >= 0.0:
            a, at_a = place, found
        else:
            b, at_b = place, found
    return a, b
