"""Runout bounds of one volume on one path, by the posterior draws of a calibrated model."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.elevation_scatter import scattered_stops
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import Pieces, RunoutBounds, bounds_of_stops, draw_stops
from avahazard.inference.model.friction_scatter import shifted, widening
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_curve import MU, RunoutCurve, friction_grid, pieces

Indices = NDArray[np.int64]


def volume_bounds(
    path: PathHazard, volume_m3: float, n_draws: int, rng: np.random.Generator
) -> RunoutBounds:
    """Bounds of the runout of one of the volumes of `path`, from `n_draws` over the posterior.

    Every draw takes one of the classes of avalanches to come.
    """
    draws, avalanches, here = path.draws, path.avalanches, path.at_volume[volume_m3]
    parameter = np.arange(n_draws) * len(draws.u) // n_draws
    event = rng.integers(avalanches.n_classes, size=n_draws)
    shift = draws.shift(rng)
    location = shifted(here.location[parameter, event], shift[parameter], avalanches.in_log)
    scatter = here.scatter[parameter, event]
    if avalanches.student:
        scatter = scatter * widening(rng, n_draws)
    if draws.sigma_m is not None:
        scatter = np.zeros(n_draws)
    curves, kind = _curves(here.curves)
    of = kind[draws.group[parameter], event]
    # Draws by one curve together: its pieces are then at hand.
    order = np.argsort(of.astype(np.uint16), kind="stable")
    x, y, counts = draw_stops(
        *(curves, of[order], location[order], scatter[order]),
        *(n_draws, rng),
        in_log=avalanches.in_log,
    )
    held = int(counts[NOT_RELEASED])
    if draws.sigma_m is not None:
        site = avalanches.site
        release_x = float(site.release_x[avalanches.release[0]])
        sigma = draws.sigma_m[parameter[order]]
        x, y, held = scattered_stops(site.smooth, release_x, y, sigma, rng)
    return bounds_of_stops(x, y, held, n_draws)


@lru_cache(maxsize=4)
def _curves(curves: tuple[RunoutCurve, ...]) -> tuple[Pieces, Indices]:
    """The curves of all groups, each once, and which of them each class has.

    The latter is `[n_groups, n_classes]`. Of the last they are kept, as `passing.stops`.
    """
    rows = [tuple(row) for row in curves[len(curves) // 2].x.tolist()]
    different = sorted(set(rows))
    first = [rows.index(row) for row in different]
    kind = np.array([different.index(row) for row in rows])
    parts = [pieces(curve[first]) for curve in curves]
    straight, status = (np.concatenate(part) for part in zip(*parts, strict=True))
    each = straight, status, friction_grid(MU)
    return each, np.add.outer(np.arange(len(curves)) * len(first), kind)
