"""How friction scatters about the law: normally, or as Student's t with 4 degrees of freedom.

With location m and scatter σ, z = (ν - m) / σ, where ν is log μ, or μ itself where friction is
normal. Student's tails let a few records be grossly wrong. Densities are in z: those in ν are 1/σ
of them. A derivative in m is -1/σ of that in z, one in log σ is -z times it.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ndtr, stdtr

from avahazard.arrays import Floats
from avahazard.kernels import kernel

DEGREES = 4
"""Degrees of freedom of Student's t; the closed forms below hold for these alone."""
NORMAL_PEAK = 1.0 / math.sqrt(2.0 * math.pi)
STUDENT_PEAK, STUDENT_PULL = 0.375, 1.25
HALF_LOG_2PI = 0.5 * math.log(2.0 * math.pi)
LOG_STUDENT_PEAK = math.log(STUDENT_PEAK)
STUDENT_INFORMATION = 8.0 / 7.0
"""Fisher information in log σ, 2 DEGREES / (DEGREES + 3); that of the normal is 2."""
ROOT_2 = math.sqrt(2.0)


@kernel(forceinline=True)
def normal_density(z: float) -> float:
    """φ(z); its derivative is -z φ."""
    return NORMAL_PEAK * math.exp(-0.5 * z * z)


@kernel(forceinline=True)
def normal_below(z: float) -> float:
    """Φ(z)."""
    return 0.5 * math.erfc(-z / ROOT_2)


@kernel(inner=True, forceinline=True)
def student_shape(z2: float) -> float:
    """1 / (1 + z²/4) for z² = `z2`: the density is STUDENT_PEAK shape^(5/2)."""
    return 1.0 / (1.0 + 0.25 * z2)


@kernel(forceinline=True)
def student_density(z: float) -> tuple[float, float, float]:
    """t(z), -t'(z)/t(z) = STUDENT_PULL z shape, and t''(z)/t(z)."""
    shape = student_shape(z * z)
    pull = STUDENT_PULL * z * shape
    density = STUDENT_PEAK * shape * shape * math.sqrt(shape)
    return density, pull, 1.4 * pull * pull - STUDENT_PULL * shape


@kernel(forceinline=True)
def student_below(z: float) -> float:
    """The chance under z, good far into the lower tail."""
    root = math.sqrt(1.0 + 0.25 * z * z)
    # z / root + 2, of which nothing is left where both are large.
    gap = 4.0 / ((2.0 * root - z) * root) if z < 0.0 else 2.0 + z / root
    return gap * gap * (4.0 - z / root) / 32.0


def below(z: Floats, student: bool) -> Floats:
    """The chance under z, of any shape."""
    return np.asarray(stdtr(float(DEGREES), z) if student else ndtr(z))


def log_density(z: Floats, student: bool) -> Floats:
    """Log density at z, of any shape."""
    if student:
        return np.asarray(LOG_STUDENT_PEAK - 2.5 * np.log1p(0.25 * z**2))
    return np.asarray(-0.5 * z**2 - HALF_LOG_2PI)


def draws(rng: np.random.Generator, size: int | tuple[int, ...], student: bool) -> Floats:
    """Draws of z."""
    return rng.standard_t(DEGREES, size=size) if student else rng.standard_normal(size)


def widening(rng: np.random.Generator, n: int) -> Floats:
    """Factors `[n]` that turn normal draws of z into Student's, whose variance is drawn."""
    return np.asarray(np.sqrt(DEGREES / rng.chisquare(DEGREES, n)))


def volume_share(volume: Floats, reference: float) -> Floats:
    """What log σ is linear in where scatter goes with volume: V over the reference, at most 1.

    Nine events in ten stay under the reference volume. Beyond it a few large events would decide
    the slope, and a straight line in V would soon let σ explode or vanish.
    """
    return np.minimum(volume / reference, 1.0)


def shifted(location: Floats, shift: Floats | float, in_log: bool) -> Floats:
    """The location with `shift` added to log friction; `in_log`: it is one of log μ."""
    return np.asarray(location + shift if in_log else location * np.exp(shift))


def widened(scatter: Floats, variance: Floats, location: Floats, in_log: bool) -> Floats:
    """The scatter with this `variance` of log friction added to it."""
    return np.asarray(np.sqrt(scatter**2 + variance * (1.0 if in_log else location**2)))


def friction(location: Floats, deviation: Floats, in_log: bool) -> Floats:
    """μ that lies `deviation` = σ z from its location."""
    return np.asarray(np.exp(location + deviation) if in_log else location + deviation)
