"""What the measured force says of an effect on the motion (docs/theory/criticism.md).

With N the load of the bed, R₀ the other effects, T the force of one effect and its share β, dE/ds =
-(μ N + R₀ + β T) on the fitted course: on the measured one, the errors of the speeds would bias β.
About a course E(ξ) that is nearly right, with c = 2 ∂(μ N + R₀ + β T)/∂u²,

    E(s) = e^{-C(s)} {E₀ - ∫ e^{C} (μ N + R₀ + β T - c E) ds},  C = ∫ c ds

(quasilinearisation; Bellman & Kalaba 1965). Repeated, this is Newton's method for the course.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from avahazard.arrays import Floats
from avahazard.effects.effect import MotionEffect, of_kind
from avahazard.effects.site import Site
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import SpeedRecord
from avahazard.physics.cells import GRAVITY, SPEEDS, Resistance

FEWEST_SPEEDS = 4
"""Of a track; two of them go to its own E₀ and μ."""
FEWEST_TRACKS = 3
MOST_STEPS, SETTLED = 30, 0.02
"""Of Gauss and Newton, and where they end: a share of the standard error."""
LEAST_KNOWN = 10.0
"""Standard error of the share of an effect beyond which the force says nothing of it."""
SHOWN, REJECTED = 1.64, 2.0
"""Standard errors: one-sided 5 % for showing an effect, two for denying the fitted amount."""
STEP_M = 5.0
MOST_DECAY = 600.0
"""Of C, whose exponential must be a number."""


class ForceWitness(NamedTuple):
    """The effect's first parameter as the force has it, its standard error, and as fitted."""

    value: float
    se: float
    fitted: float

    @property
    def denies(self) -> bool:
        """Whether the force shows no such effect, and could not have missed one as fitted."""
        share, error = self.value / self.fitted, abs(self.se / self.fitted)
        return share < SHOWN * error and share + REJECTED * error < 1.0


def force_witness(posterior: Posterior, mode: Mode, key: str) -> ForceWitness | None:
    """Fit the energies of all tracks with a share of effect `key` of the model at its mode.

    None where the effect is not on the motion or is neutral at the mode, and where the speeds are
    too few or say nothing.
    """
    motions = of_kind(posterior.effects, MotionEffect)
    effect = next((e for e in motions if e.key == key), None)
    if effect is None:
        return None
    # The strength of the effect is its distance from neutral, in the unit of its first parameter.
    fitted = float(posterior.layout.effect_values(mode.u)[key][0] - effect.neutral[0])
    tracks = _tracks(posterior, mode.u, effect) if fitted != 0.0 else []
    if len(tracks) < FEWEST_TRACKS:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # courses far off, which end the search
        found = _common_share(tracks)
    if found is None or found[1] > LEAST_KNOWN:
        return None
    share, error = found
    return ForceWitness(share * fitted, abs(error * fitted), fitted)


@dataclass(slots=True, eq=False)
class ForceTrack:
    """What resists on a track without and with the effect; energies `[n]` and friction so far."""

    course: Course
    site: Site
    rest: Resistance
    whole: Resistance
    energy: Floats
    mu: float


def _tracks(posterior: Posterior, u: Floats, effect: MotionEffect) -> list[ForceTrack]:
    """The tracks that have enough speeds, on the courses that were measured."""
    observations = posterior.observations
    values = posterior.layout.effect_values(u)
    friction = _friction(posterior, u)
    tracks = []
    for track in observations.speeds:
        if len(track.x) < FEWEST_SPEEDS or track.x[-1] <= track.x[0]:
            continue
        site = observations.sites[int(observations.columns.path_index[track.event])]
        course = course_of(site, track)
        rest = posterior.resistance(site, {**values, effect.key: effect.neutral})
        whole = posterior.resistance(site, values)
        mu = float(friction[track.event])
        tracks.append(ForceTrack(course, site, rest, whole, course.measured_energy(), mu))
    return tracks


def _common_share(tracks: Sequence[ForceTrack]) -> tuple[float, float] | None:
    """The effect's share in all tracks, its standard error by track; None without an end."""
    share = 1.0
    for _ in range(MOST_STEPS):
        fits = [(t, linear_about(t, share)) for t in tracks]
        if not all(np.isfinite(linear).all() for _, linear in fits):
            return None
        left = [_residuals(t, linear) for t, linear in fits]
        bottom = float(sum(work @ work for _, work in left))
        if not 0.0 < bottom < np.inf:
            return None
        before, share = share, float(sum(work @ energy for energy, work in left)) / bottom
        for track, linear in fits:
            _follow(track, linear, share)
        scores = np.array([work @ (energy - share * work) for energy, work in left])
        n = len(scores)
        clustered = float(np.sqrt(n / (n - 1) * np.sum(scores**2))) / bottom
        error = max(clustered, bottom**-0.5)
        if abs(share - before) < SETTLED * error:
            return share, error
    return None


def _standardised(track: ForceTrack, linear: Linear) -> tuple[Floats, Floats]:
    """Energies less what is fixed `[n_speeds]`, in standard errors, and their derivatives.

    By own energy, friction and share, `[n_speeds, 3]`.
    """
    course, at = track.course, track.course.at
    fitted = np.sqrt(course.square(track.energy)[at])
    error = np.maximum(fitted, course.sigma) * course.sigma
    energy = track.energy[at] + fitted * (course.speed - fitted)
    columns = np.stack([linear.start, linear.load, linear.effect], axis=1)
    return (energy - linear.fixed[at]) / error, columns[at] / error[:, None]


def _residuals(track: ForceTrack, linear: Linear) -> tuple[Floats, Floats]:
    """Energies and the effect's work `[n_speeds]` in standard errors, less what is its own."""
    energy, columns = _standardised(track, linear)
    both, own = np.stack([energy, columns[:, 2]], axis=1), columns[:, :2]
    energy, work = (both - own @ np.linalg.lstsq(own, both, rcond=None)[0]).T
    return energy, work


def _follow(track: ForceTrack, linear: Linear, share: float) -> None:
    """Set the energies and the friction of a track to those that fit it best."""
    energy, columns = _standardised(track, linear)
    left = energy - share * columns[:, 2]
    start, mu = np.linalg.lstsq(columns[:, :2], left, rcond=None)[0]
    rest = linear.fixed + share * linear.effect
    track.energy, track.mu = rest + start * linear.start + mu * linear.load, float(mu)


def _friction(posterior: Posterior, u: Floats) -> Floats:
    """Median friction of each event `[n_events]` at coordinates u."""
    volume = np.exp(posterior.volumes(u).mean)[:, None]
    location = posterior.friction.location_and_scatter(u, volume, posterior.of_events)[0][:, 0]
    return np.exp(location) if posterior.layout.log_scatter else location


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


class Linear(NamedTuple):
    """Derivatives of the energy along a course `[n]` by E₀, μ and the effect's share; the rest."""

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


def linear_about(track: ForceTrack, share: float) -> Linear:
    """The linear solution about a track's energies and friction, and a share of the effect."""
    course = track.course
    square = course.square(track.energy)
    step = np.maximum(0.01 * square, 0.1)
    load, other, effect = forces = _forces(track, square)
    both = forces, _forces(track, square + step)
    slow, fast = (track.mu * mu + rest + share * own for mu, rest, own in both)
    grows = (fast - slow) / step
    # Any c has the same end. One far below 0 (friction that falls with speed) would not find it.
    length = cumulative_trapezoid(course.stretch, course.x)[-1]
    pull = np.maximum(2.0 * grows, -1.0 / length)
    decay = cumulative_trapezoid(pull * course.stretch, course.x, initial=0)
    decay = np.minimum(decay, MOST_DECAY)

    def taken(force: Floats) -> Floats:
        """What a force takes off the energy, less what the others then take no more."""
        grown = np.exp(decay) * force * course.stretch
        return np.asarray(-np.exp(-decay) * cumulative_trapezoid(grown, course.x, initial=0))

    fixed = taken(other - pull * track.energy)
    return Linear(np.exp(-decay), taken(load), taken(effect), fixed)


def _forces(track: ForceTrack, square: Floats) -> tuple[Floats, Floats, Floats]:
    """Forces per mass (m/s2) `[n]` at squared speeds: for μ = 1, of other effects, of this one."""
    course = track.course
    centrifugal = track.rest.curvature * course.curvature * square
    load = np.maximum(GRAVITY / course.stretch + centrifugal, 0.0)
    _, with_it = _force(track, track.whole, square, load)
    factor, without = _force(track, track.rest, square, load)
    plain = factor * load
    return plain, without - track.mu * plain, with_it - without


def _force(
    track: ForceTrack, resistance: Resistance, square: Floats, load: Floats
) -> tuple[Floats, Floats]:
    """The factor of friction and the resisting force per mass (m/s2) of `Resistance`."""
    terrain = track.site.terrain_for(resistance)
    inside = np.searchsorted(terrain.x, track.course.x, side="right") - 1
    cell = np.clip(inside, 0, terrain.n_cells - 1)
    factor = resistance.factor[cell]
    speed = np.sqrt(square)
    factor = factor * np.interp(speed, SPEEDS, resistance.speed_factor)
    force = track.mu * factor * load
    force = force + resistance.offset[cell] * load + resistance.constant[cell]
    force = force + np.interp(speed, SPEEDS, resistance.speed_constant)
    return factor, force + resistance.drag[cell] * square
