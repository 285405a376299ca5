"""Yearly rates past places, and places passed at a rate, draw by draw, compiled.

The share of avalanches with friction under ν is a sum of normal probabilities over all volumes,
smooth over a scatter: from its density and two derivatives of that at nodes, five to a scatter, its
value anywhere follows by quintic Hermite interpolation within 1e-8 (docs/theory/hazard.md).
"""

import math
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.inference.model.friction_model import (
    normal_below,
    normal_density,
    student_below,
    student_density,
)
from avahazard.kernels import bare, kernel
from avahazard.physics.runout_curve import inverse

FAR = 8.5
"""Standard scatters past which the normal distribution is 0 or 1 to the last bit."""
REACH = 6.5
"""Standard scatters to which curves go: past them lie 4e-11 of a normal distribution."""


class ShareCurves(NamedTuple):
    """Shares of avalanches, by draw and kind (classes of like friction).

    ν is log μ, or μ. Share = Σ_v `weight` P(z < (ν - `location`) / `scatter`) - `none`, with
    `location`, `scatter`, `weight` `[n_parameters, n_kinds, n_volumes]` and `none` (of a friction
    under 0) `[n_parameters, n_kinds]`. Node k of a curve lies at ν = `low` + k / `per_step`, both
    `[n_parameters, n_kinds]`; `nodes` `[n_parameters, n_kinds, n_nodes, 3]` hold the share there,
    its density and the derivative of that in steps, and are empty where nothing is tabulated.
    """

    location: Floats
    scatter: Floats
    weight: Floats
    none: Floats
    low: Floats
    per_step: Floats
    n_nodes: Ints
    nodes: Floats
    student: bool


@kernel(forceinline=True)
def below(z, student):  # type: ignore[no-untyped-def]
    """The chance under z."""
    if student:
        return student_below(z)
    if z < -FAR:
        return 0.0
    if z > FAR:
        return 1.0
    return normal_below(z)


@kernel(forceinline=True)
def summed_share(curves, p, k, nu):  # type: ignore[no-untyped-def]
    """The share of draw p and kind k with friction under ν, by its definition."""
    total = -curves.none[p, k]
    for v in range(curves.location.shape[2]):
        if curves.weight[p, k, v] > 0.0:
            z = (nu - curves.location[p, k, v]) / curves.scatter[p, k, v]
            total += curves.weight[p, k, v] * below(z, curves.student)
    return total


@kernel
def tabulate(curves):  # type: ignore[no-untyped-def]
    """Fill in the nodes of the curves."""
    density = np.empty((3, curves.nodes.shape[2]))
    for p in range(curves.low.shape[0]):
        for k in range(curves.low.shape[1]):
            n, step = curves.n_nodes[p, k], 1.0 / curves.per_step[p, k]
            density[:, :n] = 0.0
            for v in range(curves.location.shape[2]):
                weight, scatter = curves.weight[p, k, v], curves.scatter[p, k, v]
                if weight > 0.0:
                    z = (curves.low[p, k] - curves.location[p, k, v]) / scatter
                    if curves.student:
                        _add_student(density, n, z, step / scatter, weight)
                    else:
                        _add_normal(density, n, z, step / scatter, weight)
            node = curves.nodes[p, k]
            node[0, 0] = summed_share(curves, p, k, curves.low[p, k])
            for j in range(n):
                node[j, 1], node[j, 2] = density[0, j], density[1, j]
            for j in range(1, n):
                # The integral of the quintic through density and derivatives at both ends.
                node[j, 0] = node[j - 1, 0] + (
                    (density[0, j - 1] + density[0, j]) / 2.0
                    + (density[1, j - 1] - density[1, j]) / 10.0
                    + (density[2, j - 1] + density[2, j]) / 120.0
                )


@kernel(inner=True, forceinline=True)
def _add_normal(density, n, z, step, weight):  # type: ignore[no-untyped-def]
    """Add `weight` of φ at z and n - 1 `step`s on, with two derivatives, in steps `[3, n_nodes]`.

    φ(z + h) = φ(z) e^(-h (z + h/2)), and this factor falls by e^(-h²) from step to step: no node
    takes an exponential of its own.
    """
    first = max(0, math.ceil((-REACH - z) / step))
    end = min(n, int((REACH - z) / step) + 1)
    z += first * step
    value = weight * step * normal_density(z)
    ratio, fall = math.exp(-step * (z + 0.5 * step)), math.exp(-step * step)
    for j in range(first, end):
        density[0, j] += value
        density[1, j] -= value * z * step
        density[2, j] += value * (z * z - 1.0) * step * step
        value *= ratio
        ratio *= fall
        z += step


@kernel(inner=True, forceinline=True)
def _add_student(density, n, z, step, weight):  # type: ignore[no-untyped-def]
    """The same of Student's t."""
    for j in range(n):
        value, pull, bend = student_density(z + j * step)
        value *= weight * step
        density[0, j] += value
        density[1, j] -= value * pull * step
        density[2, j] += value * bend * step * step


@kernel(forceinline=True)
def share_under(curves, p, k, nu):  # type: ignore[no-untyped-def]
    """The share of draw p and kind k with friction under ν, by its curve; 0 to 1."""
    if curves.nodes.size == 0:
        return summed_share(curves, p, k, nu)
    nodes = curves.nodes
    t = (nu - curves.low[p, k]) * curves.per_step[p, k]
    last = curves.n_nodes[p, k] - 1
    if t <= 0.0:
        return max(nodes[p, k, 0, 0], 0.0)
    if t >= last:
        return nodes[p, k, last, 0]
    j = int(t)
    t -= j
    near, steep, bent = nodes[p, k, j, 0], nodes[p, k, j, 1], nodes[p, k, j, 2]
    # What share, density and its derivative at the far end differ by from a parabola.
    rise = nodes[p, k, j + 1, 0] - near - steep - 0.5 * bent
    slope = nodes[p, k, j + 1, 1] - steep - bent
    bend = 0.5 * (nodes[p, k, j + 1, 2] - bent)
    third = 10.0 * rise - 4.0 * slope + bend
    fourth = -15.0 * rise + 7.0 * slope - 2.0 * bend
    fifth = 6.0 * rise - 3.0 * slope + bend
    value = near + t * (steep + t * (0.5 * bent + t * (third + t * (fourth + t * fifth))))
    return max(value, 0.0)


class Descent(NamedTuple):
    """`Avalanches` as the kernels take them.

    `falling` `[n_groups, n_classes, n_friction]`: x of the stops (inf where the profile was left);
    `discontinuous` `[n_groups, n_classes, n_friction - 1]` as in `RunoutCurve`; `group`, `rate`
    `[n_parameters]`; `class_share`, `kind` `[n_classes]`, the kind of friction in `shares`.
    """

    falling: Floats
    discontinuous: Bools
    group: Ints
    class_share: Floats
    rate: Floats
    kind: Ints
    shares: ShareCurves
    in_log: bool


@kernel
def rates_at(descent, x):  # type: ignore[no-untyped-def]
    """Rates `[n_places, n_parameters]` of what stops beyond places x (m) `[n_places]`."""
    descent = bare(descent)
    n_groups, n_classes, _ = descent.falling.shape
    nu = np.empty((n_groups, n_classes))
    result = np.empty((len(x), len(descent.rate)))
    for i in range(len(x)):
        for g in range(n_groups):
            for c in range(n_classes):
                nu[g, c] = _threshold(descent, g, c, x[i])
        for p in range(len(descent.rate)):
            total = 0.0
            for c in range(n_classes):
                total += descent.class_share[c] * _share(descent, p, c, nu[descent.group[p], c])
            result[i, p] = descent.rate[p] * total
    return result


@kernel(inner=True, forceinline=True)
def _threshold(descent, g, c, x):  # type: ignore[no-untyped-def]
    """ν under which a block of group g and class c stops beyond x; -inf never, inf always."""
    mu = inverse(descent.falling[g, c], descent.discontinuous[g, c], x)
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
def _rate_past(descent, p, x):  # type: ignore[no-untyped-def]
    """The rate of draw p past x (m)."""
    g, total = descent.group[p], 0.0
    for c in range(descent.falling.shape[1]):
        total += descent.class_share[c] * _share(descent, p, c, _threshold(descent, g, c, x))
    return descent.rate[p] * total


@kernel
def exceeded_places(descent, wanted, low, high, halvings):  # type: ignore[no-untyped-def]
    """x (m) `[n_parameters]` passed at the rates `wanted` `[n_parameters]`, or `[n]` of one draw.

    As `exceedance.exceeded`, bit for bit.
    """
    descent, result = bare(descent), np.empty(len(wanted))
    for i in range(len(wanted)):
        p = i if len(descent.rate) > 1 else 0
        if _rate_past(descent, p, high) >= wanted[i]:
            result[i] = np.inf
            continue
        bottom, top = low, high
        for _ in range(halvings):
            middle = 0.5 * (bottom + top)
            if _rate_past(descent, p, middle) >= wanted[i]:
                bottom = middle
            else:
                top = middle
        # Nothing was ever often enough: the lowest level itself.
        result[i] = low if bottom == low else 0.5 * (bottom + top)
    return result
