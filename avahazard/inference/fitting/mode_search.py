"""The highest of several modes, where effects that shape the tables have more than one.

A climb can stop where such an effect is not there at all: friction has taken its part, and a
little of the effect is worse than none. So the climb is made again from the best point of a
coarse grid of the effect's parameters. A climb on a coarse grid can also stop on a peak that is
none (`refinement`), so the climbs are compared once their grids are settled.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import MotionEffect
from avahazard.inference.fitting.mode import Mode, climb, find_mode
from avahazard.inference.fitting.refinement import settled
from avahazard.inference.likelihood.posterior import Posterior

FIRST_POINTS, OTHER_POINTS = 5, 3
"""Points tried of the first parameter of an effect, and of each other one."""
SLOW_POINTS = 3, 2
"""The same where friction depends on speed, whose runs are costly."""
ITERATIONS = 20


def search_mode(posterior: Posterior, start: Floats | None = None) -> tuple[Posterior, Mode]:
    """The highest mode found from `start` (or the data) and from coarse grids, effect by effect.

    With it, the posterior on grids on which it stands.
    """
    climbs = _climbs(posterior, start)
    best = settled(posterior, climbs[0])
    for mode in climbs[1:]:
        if mode.log_density <= best[1].log_density:
            break
        other = settled(posterior, mode)
        if other[1].log_density > best[1].log_density:
            best = other
    return best


def _climbs(posterior: Posterior, start: Floats | None) -> list[Mode]:
    """The ends of all climbs, the highest first."""
    found = [find_mode(posterior, start)]
    for effect in posterior.effects:
        place = posterior.layout.places.get(effect.key, slice(0, 0))
        held = [k for k in posterior.layout.tables if place.start <= k < place.stop]
        if not held:
            continue
        slow = isinstance(effect, MotionEffect) and effect.speed_dependent
        first, other = SLOW_POINTS if slow else (FIRST_POINTS, OTHER_POINTS)
        grids = [
            thinned(posterior.layout.slots[k].grid, other if j else first)
            for j, k in enumerate(held)
        ]
        best = max(found, key=lambda mode: mode.log_density)
        tried = [held_climb(posterior, best.u, held, corner) for corner in product(*grids)]
        value, u = max(tried, key=lambda fit: fit[0])
        if np.isfinite(value):
            found.append(find_mode(posterior, u))
    return sorted(found, key=lambda mode: -mode.log_density)


def thinned(grid: Sequence[float], n: int) -> list[float]:
    """At most n values of a grid, its ends among them."""
    return [grid[k] for k in np.unique(np.linspace(0, len(grid) - 1, n).round().astype(int))]


def held_climb(
    posterior: Posterior, u: Floats, held: Sequence[int], corner: Sequence[float]
) -> tuple[float, Floats]:
    """Log density and coordinates of a short climb from u with slots `held` kept at `corner`."""
    free = np.array([k for k in range(len(u)) if k not in held])
    start = u.copy()
    start[list(held)] = corner
    reached, cost = climb(posterior, start, free, ITERATIONS)
    return -cost, reached
