"""Energy along a track of speeds, as the forces of a model take it from the block.

Energy per mass E = u²/2 + g y falls by the work of what resists,

    dE/ds = -(μ N + R₀ + β T),

with N the load of the bed, R₀ the other effects of a model and T the force of one effect. They
depend on the speed, so on E itself. About a course E(ξ) that is nearly right the equation is
linear, and its solution is linear in the energy at the first speed, in μ and in β: with
c = 2 ∂(μ N + R₀ + β T)/∂u²,

    E(s) = e^{-C(s)} {E₀ - ∫ e^{C} (μ N + R₀ + β T - c E) ds},  C = ∫ c ds

(quasilinearisation; Bellman & Kalaba 1965). Repeated, this is Newton's method for the course.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.inference.model.observations import SpeedRecord
from avahazard.physics.constants import GRAVITY
from avahazard.physics.resistance import SPEEDS, Resistance

STEP_M = 5.0
MOST_DECAY = 600.0
"""Of C, whose exponential must be a number."""


class Course(NamedTuple):
    """Places along a track, from its first speed to its last, and the ground there.

    `x` `[n]` are some `STEP_M` apart; `at` `[n_speeds]` are those of the speeds (m/s), with their
    errors `sigma`.
    """

    x: Floats
    height: Floats
    stretch: Floats
    curvature: Floats
    at: NDArray[np.int64]
    speed: Floats
    sigma: Floats

    def measured_energy(self) -> Floats:
        """Energy `[n]` (m2/s2) of the speeds, straight between them."""
        energy = 0.5 * self.speed**2 + GRAVITY * self.height[self.at]
        return np.interp(self.x, self.x[self.at], energy)

    def square(self, energy: Floats) -> Floats:
        """Squared speeds `[n]` of energies."""
        return np.maximum(2.0 * (energy - GRAVITY * self.height), 0.0)


class Forces(NamedTuple):
    """Forces per mass (m/s2) `[n]` along a course: for μ = 1, of other effects, of the effect."""

    load: Floats
    other: Floats
    effect: Floats

    def sum(self, mu: float, share: float) -> Floats:
        """All that resists, with friction μ and a share of the effect."""
        return np.asarray(mu * self.load + self.other + share * self.effect)


class Linear(NamedTuple):
    """The energy along a course `[n]` as a linear function of E₀, μ and the effect's share.

    `start`, `load` and `effect` are its derivatives, `fixed` is the rest.
    """

    start: Floats
    load: Floats
    effect: Floats
    fixed: Floats


def course_of(site: Site, track: SpeedRecord) -> Course:
    """The places of a track, with the ground under them."""
    x = np.concatenate(
        [
            np.linspace(a, b, max(2, int(np.ceil((b - a) / STEP_M))), endpoint=False)
            for a, b in zip(track.x[:-1], track.x[1:], strict=True)
        ]
        + [track.x[-1:]]
    )
    height, slope, bend = site.smooth.derivatives(x)
    at = np.searchsorted(x, track.x)
    stretch = np.hypot(1.0, slope)
    return Course(x, height, stretch, bend / stretch**3, at, track.speed, track.sigma)


def linear_about(
    course: Course,
    site: Site,
    rest: Resistance,
    whole: Resistance,
    energy: Floats,
    mu: float,
    share: float,
) -> Linear:
    """The linear solution about a course of energies `[n]`, and friction and share there.

    `rest` resists without the effect, `whole` with it.
    """
    square = course.square(energy)
    step = np.maximum(0.01 * square, 0.1)
    forces = _forces(course, site, rest, whole, square, mu)
    faster = _forces(course, site, rest, whole, square + step, mu)
    grows = (faster.sum(mu, share) - forces.sum(mu, share)) / step
    # Any c has the same end. One far below 0 (friction that falls with speed) would not find it.
    pull = np.maximum(2.0 * grows, -1.0 / _integral(course.x, course.stretch)[-1])
    decay = np.minimum(_integral(course.x, pull * course.stretch), MOST_DECAY)

    def taken(force: Floats) -> Floats:
        """What a force takes off the energy, less what the others then take no more."""
        grown = np.exp(decay) * force * course.stretch
        return np.asarray(-np.exp(-decay) * _integral(course.x, grown))

    fixed = taken(forces.other - pull * energy)
    return Linear(np.exp(-decay), taken(forces.load), taken(forces.effect), fixed)


def _forces(
    course: Course, site: Site, rest: Resistance, whole: Resistance, square: Floats, mu: float
) -> Forces:
    """The forces at squared speeds along a course."""
    load = GRAVITY / course.stretch + rest.curvature * course.curvature * square
    load = np.maximum(load, 0.0)
    with_it = _force(site, whole, course.x, square, load, mu)
    without = _force(site, rest, course.x, square, load, mu)
    plain = _friction_factor(site, rest, course.x, square) * load
    return Forces(plain, without - mu * plain, with_it - without)


def _force(
    site: Site, resistance: Resistance, x: Floats, square: Floats, load: Floats, mu: float
) -> Floats:
    """Resisting force per mass (m/s2) at places x with squared speeds, as `Resistance` has it."""
    cell = _cells(site, resistance, x)
    force = mu * _friction_factor(site, resistance, x, square) * load
    force = force + resistance.offset[cell] * load + resistance.constant[cell]
    if resistance.speed_constant is not None:
        force = force + np.interp(np.sqrt(square), SPEEDS, resistance.speed_constant)
    return np.asarray(force + resistance.drag[cell] * square)


def _friction_factor(site: Site, resistance: Resistance, x: Floats, square: Floats) -> Floats:
    factor = resistance.factor[_cells(site, resistance, x)]
    if resistance.speed_factor is not None:
        factor = factor * np.interp(np.sqrt(square), SPEEDS, resistance.speed_factor)
    return np.asarray(factor)


def _cells(site: Site, resistance: Resistance, x: Floats) -> NDArray[np.int64]:
    terrain = site.terrain_for(resistance)
    inside = np.searchsorted(terrain.x, x, side="right") - 1
    return np.clip(inside, 0, terrain.n_cells - 1)


def _integral(x: Floats, values: Floats) -> Floats:
    """∫ values dx from the first place, by the trapezium rule."""
    pieces = 0.5 * (values[1:] + values[:-1]) * np.diff(x)
    return np.concatenate([[0.0], np.cumsum(pieces)])
