"""What the measured force says of an effect on the motion.

Stops and volumes alone can ask for an effect that is in no force: it mends something else. Where
speeds exist they are a witness: along a track energy falls by the work of what resists
(`track_energy`). Each track has its own energy at its first speed and its own friction; the share β
of the fitted effect, common to all, is 1 where the force bears the fit out and 0 where it knows
nothing of the effect. It is found by least squares of the speeds, whose errors are independent of
each other, which those of their derivative (Ancey & Meunier 2004) are not. Forces and weights are
those on the fitted course: on the measured one, the errors of the speeds would be in what explains
as well, and bias β.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.track_energy import Course, Linear, course_of, linear_about
from avahazard.effects.effect import MotionEffect, of_kind
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior

FEWEST_SPEEDS = 4
"""Of a track; two of them go to its own E₀ and μ."""
FEWEST_TRACKS = 3
MOST_STEPS, SETTLED = 30, 0.02
"""Of Gauss and Newton, and where they end: a share of the standard error."""
SHOWN, REJECTED = 1.64, 2.0
"""Standard errors: one-sided 5 % for showing an effect, two for denying the fitted amount."""


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

    None where the effect is not on the motion, is neutral at the mode, or the speeds are too few.
    """
    motions = of_kind(posterior.effects, MotionEffect)
    effect = next((e for e in motions if e.key == key), None)
    values = posterior.layout.effect_values(mode.u)
    if effect is None or np.array_equal(values[key], effect.neutral):
        return None
    # The strength of the effect is its distance from neutral, in the unit of its first parameter.
    fitted = float(values[key][0] - effect.neutral[0])
    if fitted == 0.0:
        return None
    tracks = _tracks(posterior, mode.u, key)
    if len(tracks) < FEWEST_TRACKS:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # courses far off, which end the search
        found = _common_share(tracks)
    if found is None:
        return None
    share, error = found
    return ForceWitness(share * fitted, abs(error * fitted), fitted)


@dataclass(slots=True, eq=False)
class _Track:
    """A track with what resists on it, and the energies `[n]` and friction fitted to it so far."""

    course: Course
    linear: Callable[[Floats, float, float], Linear]
    energy: Floats
    mu: float


def _tracks(posterior: Posterior, u: Floats, key: str) -> list[_Track]:
    """The tracks that have enough speeds, on the courses that were measured."""
    observations = posterior.observations
    values = posterior.layout.effect_values(u)
    (effect,) = (e for e in posterior.effects if e.key == key)
    friction = _friction(posterior, u)
    tracks = []
    for track in observations.speeds:
        if len(track.x) < FEWEST_SPEEDS or track.x[-1] <= track.x[0]:
            continue
        site = observations.sites[int(observations.columns.path_index[track.event])]
        course = course_of(site, track)
        about = partial(
            linear_about,
            course,
            site,
            posterior.resistance(site, {**values, key: effect.neutral}),
            posterior.resistance(site, values),
        )
        mu = float(friction[track.event])
        tracks.append(_Track(course, about, course.measured_energy(), mu))
    return tracks


def _common_share(tracks: Sequence[_Track]) -> tuple[float, float] | None:
    """The share of the effect in all tracks, with its standard error.

    None where no course depends on it, or Gauss and Newton's steps find no end. The standard error
    is clustered by track (its speeds share what the model lacks), and never less than what the
    errors of the speeds ask for.
    """
    share = 1.0
    for _ in range(MOST_STEPS):
        fits = [(t, t.linear(t.energy, t.mu, share)) for t in tracks]
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


def _standardised(track: _Track, linear: Linear) -> tuple[Floats, Floats]:
    """What the course must explain, in standard errors of the speeds, and what may explain it.

    The energies at the speeds less what is fixed `[n_speeds]`, as errors of the speeds about the
    course make them; derivatives by the track's own energy, its friction, and the effect's share
    `[n_speeds, 3]`.
    """
    course, at = track.course, track.course.at
    fitted = np.sqrt(course.square(track.energy)[at])
    error = np.maximum(fitted, course.sigma) * course.sigma
    energy = track.energy[at] + fitted * (course.speed - fitted)
    columns = np.stack([linear.start, linear.load, linear.effect], axis=1)
    return (energy - linear.fixed[at]) / error, columns[at] / error[:, None]


def _residuals(track: _Track, linear: Linear) -> tuple[Floats, Floats]:
    """Energies and the effect's work `[n_speeds]` in standard errors, less what is its own."""
    energy, columns = _standardised(track, linear)
    both = np.stack([energy, columns[:, 2]], axis=1)
    own = columns[:, :2]
    energy, work = (both - own @ np.linalg.lstsq(own, both, rcond=None)[0]).T
    return energy, work


def _follow(track: _Track, linear: Linear, share: float) -> None:
    """Set the energies and the friction of a track to those that fit it best."""
    energy, columns = _standardised(track, linear)
    left = energy - share * columns[:, 2]
    start, mu = np.linalg.lstsq(columns[:, :2], left, rcond=None)[0]
    rest = linear.fixed + share * linear.effect
    track.energy, track.mu = rest + start * linear.start + mu * linear.load, float(mu)


def _friction(posterior: Posterior, u: Floats) -> Floats:
    """Median friction of each event `[n_events]` at coordinates u."""
    volume = np.exp(posterior.volumes(u).mean)[:, None]
    location = posterior.location_and_scatter(u, volume)[0][:, 0]
    return np.exp(location) if posterior.layout.log_scatter else location
