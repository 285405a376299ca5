"""Impact pressure of the flow: p = ρ u²."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats


def draw_densities(mean: float, sd: float, n: int, rng: np.random.Generator) -> Floats:
    """Flow densities `[n]` in kg/m3: lognormal with this mean and standard deviation."""
    variance = np.log1p((sd / mean) ** 2)
    noise = rng.standard_normal(n)
    return np.asarray(np.exp(np.log(mean) - 0.5 * variance + np.sqrt(variance) * noise))


def pressure_kpa(density: Floats, speed: Floats) -> Floats:
    """ρ u² in kPa.

    Of `density` `[n_parameters]` (kg/m3) and `speed` `[..., n_parameters, n_places]` (m/s).
    """
    return np.asarray(density[:, None] * speed**2 / 1000.0)
