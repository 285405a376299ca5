"""What the measured force says of an effect on the motion.

Stops and volumes alone can ask for an effect that is in no force: it mends something else. Where
speeds exist they are a witness. Along a track, energy per mass E = u²/2 + g y falls by the work of
what resists,

    E(ξ) = E₀ - μ ∫ N dξ - ∫ R₀ dξ - β ∫ T dξ,

with N the load of the bed, R₀ the other effects of the model and T the force of the effect as it
was fitted. Each track has its own E₀ and μ; β, common to all, is 1 where the force bears the fit
out and 0 where it knows nothing of the effect. Speeds enter E with errors u σ that are independent
of each other, which a derivative of them (Ancey & Meunier 2004) has not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.speed_record import SpeedRecord
from avahazard.physics.constants import GRAVITY
from avahazard.physics.resistance import SPEEDS, Resistance

FEWEST_SPEEDS = 4
"""Of a track; two of them go to its own E₀ and μ."""
FEWEST_TRACKS = 3
STEP_M = 5.0
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
    """Regress the energy of all tracks on the work of effect `key` of the model at its mode.

    None where the effect is not on the motion, is neutral at the mode, or the speeds are too few.
    The standard error is clustered by track (its speeds share what the model lacks), and never
    less than what the errors of the speeds ask for.
    """
    effect = next((e for e in posterior.effects if e.key == key), None)
    observations = posterior.observations
    values = posterior.layout.effect_values(mode.u)
    if effect is None or effect.motion is None or np.array_equal(values[key], effect.neutral):
        return None
    # The strength of the effect is its distance from neutral, in the unit of its first parameter.
    fitted = float(values[key][0] - effect.neutral[0])
    if fitted == 0.0:
        return None
    friction = _friction(posterior, mode.u)
    without = {**values, key: effect.neutral}
    top, bottom, variance = [], [], []
    for track in observations.speeds:
        if len(track.x) < FEWEST_SPEEDS:
            continue
        site = observations.sites[int(observations.columns.path_index[track.event])]
        whole = posterior.resistance(site, values)
        rest = posterior.resistance(site, without)
        energy, load, other, work = _along(site, track, rest, whole, float(friction[track.event]))
        left = _residuals(track, load, np.stack([-(energy + other), work]))
        top.append(left[1] @ left[0])
        bottom.append(left[1] @ left[1])
        variance.append(left)
    if len(bottom) < FEWEST_TRACKS or sum(bottom) <= 0.0:
        return None
    share = float(sum(top) / sum(bottom))
    scores = np.array([work @ (energy - share * work) for energy, work in variance])
    n = len(scores)
    clustered = np.sqrt(n / (n - 1) * np.sum(scores**2)) / sum(bottom)
    error = max(float(clustered), float(sum(bottom) ** -0.5))
    return ForceWitness(share * fitted, abs(error * fitted), fitted)


def _friction(posterior: Posterior, u: Floats) -> Floats:
    """Median friction of each event `[n_events]` at coordinates u."""
    volume = np.exp(posterior.volumes(u).mean)[:, None]
    location = posterior.location_and_scatter(u, volume)[0][:, 0]
    return np.exp(location) if posterior.layout.log_scatter else location


def _along(
    site: Site, track: SpeedRecord, rest: Resistance, whole: Resistance, mu: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Energy at the places of a track `[n_speeds]`, and the work done up to them.

    The work is that of the bed's load (for μ = 1), of the other effects, and of the effect itself.
    Between the places energy goes straight, and the ground is known.
    """
    smooth = site.smooth
    inner = np.concatenate(
        [
            np.linspace(a, b, max(2, int(np.ceil((b - a) / STEP_M))), endpoint=False)
            for a, b in zip(track.x[:-1], track.x[1:], strict=True)
        ]
        + [track.x[-1:]]
    )
    height, slope, bend = smooth.derivatives(inner)
    at = np.searchsorted(inner, track.x)
    energy = 0.5 * track.speed**2 + GRAVITY * height[at]
    square = np.maximum(2.0 * (np.interp(inner, track.x, energy) - GRAVITY * height), 0.0)
    stretch = np.hypot(1.0, slope)
    curvature = bend / stretch**3
    load = GRAVITY / stretch + rest.curvature * curvature * square
    load = np.maximum(load, 0.0)
    with_it = _force(site, whole, inner, square, load, mu)
    without = _force(site, rest, inner, square, load, mu)
    plain = _friction_factor(site, rest, inner, square) * load
    places = [
        _work(inner, force * stretch)[at]
        for force in (plain, without - mu * plain, with_it - without)
    ]
    return energy, places[0], places[1], places[2]


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


def _work(x: Floats, force: Floats) -> Floats:
    """∫ force dx from the first place, by the trapezium rule."""
    pieces = 0.5 * (force[1:] + force[:-1]) * np.diff(x)
    return np.concatenate([[0.0], np.cumsum(pieces)])


def _residuals(track: SpeedRecord, load: Floats, columns: Floats) -> Floats:
    """`columns` `[2, n_speeds]` in standard errors, less what E₀ and μ of the track explain."""
    weight = 1.0 / np.maximum(track.speed * track.sigma, 1e-3)
    own = np.stack([np.ones_like(load), load]) * weight
    scaled = columns * weight
    fitted = np.linalg.lstsq(own.T, scaled.T, rcond=None)[0]
    return np.asarray(scaled - (own.T @ fitted).T)
