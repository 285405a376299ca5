"""The highest of several modes, where effects that shape the tables have more than one.

A climb can stop where such an effect is not there at all: friction has taken its part, and a
little of the effect is worse than none. So the climb begins at the best of some plausible values of
the effect's parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Effect
from avahazard.inference.fitting.mode import Mode, climb, find_mode, start_coordinates
from avahazard.inference.fitting.star import gauss_newton, starred
from avahazard.inference.likelihood.posterior import Posterior

FIRST_POINTS, OTHER_POINTS = 5, 3
"""Values tried of the first parameter of an effect, and of each other one."""
TRACK_SCATTERS = (-1.2, 0.0, 1.2)
"""Logs of the scatters along tracks that are tried, from the most plausible one."""
ITERATIONS = 20


def search_mode(posterior: Posterior, start: Floats | None = None) -> tuple[Posterior, Mode]:
    """The highest mode found from `start` (or the data) and from plausible values of effects.

    With it, the posterior on the star about it (`star`).
    """
    layout = posterior.layout
    u = start_coordinates(posterior) if start is None else np.clip(start, layout.low, layout.high)
    if not posterior.nodes.varies:
        return posterior, find_mode(posterior, u)
    peaks = [gauss_newton(posterior, u)]
    for effect in posterior.effects:
        place = layout.places.get(effect.key, slice(0, 0))
        held = [k for k in layout.tables if place.start <= k < place.stop]
        if held:
            best = max(peaks, key=lambda peak: peak.log_density).u
            scales = [layout.slots[k].scale for k in held]
            values = [v / scales for v in _tried(effect)]
            if layout.track_scatter is not None:
                # With the effect less is left to scatter along tracks.
                middle = layout.slots[layout.track_scatter].mean
                held = [*held, layout.track_scatter]
                values = [np.append(v, middle + s) for v in values for s in TRACK_SCATTERS]
            tried = [held_climb(posterior, best, held, v) for v in values]
            peaks.append(gauss_newton(posterior, max(tried, key=lambda climb: climb[0])[1]))
    return starred(posterior, max(peaks, key=lambda peak: peak.log_density))


def _tried(effect: Effect) -> list[Floats]:
    """Values of an effect's parameters `[n_parameters]`."""
    first, *others = effect.parameters
    between = (np.linspace(p.low, p.high, OTHER_POINTS) for p in others)
    return [np.array(corner) for corner in product(first.plausible(FIRST_POINTS), *between)]


def held_climb(
    posterior: Posterior, u: Floats, held: Sequence[int], values: Sequence[float] | Floats
) -> tuple[float, Floats]:
    """Log density and coordinates of a short climb from u with slots `held` kept at `values`.

    All that shapes the tables is held as well, where it is.
    """
    start = u.copy()
    start[list(held)] = values
    slots = posterior.layout.slots
    free = [k for k, slot in enumerate(slots) if not slot.arm and k not in held]
    reached, cost = climb(posterior.pinned(start), start, np.array(free, np.int64), ITERATIONS)
    return -cost, reached
