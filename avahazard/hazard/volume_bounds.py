"""Runout bounds of one volume on one path, by the posterior draws of a calibrated model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.elevation_scatter import scattered_stops
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import RunoutBounds, bounds_of_stops, draw_runouts
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.friction_scatter import shifted, widening
from avahazard.physics.block import NOT_RELEASED

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
    location = here.location[parameter, event]
    shift = draws.shift(rng)
    location = shifted(location, shift[parameter], avalanches.in_log)
    friction = np.exp(location) if avalanches.in_log else location
    scatter = here.scatter[parameter, event]
    if avalanches.student:
        scatter = scatter * widening(rng, n_draws)
    if draws.sigma_m is not None:
        scatter = np.zeros(n_draws)
    xs, ys, held = [], [], 0
    for mine in _alike(draws.group[parameter], _kinds(here.tables)[event]):
        curve = here.tables[int(draws.group[parameter[mine[0]]])].curve
        x, y, counts = draw_runouts(
            curve[int(event[mine[0]])],
            friction[mine],
            scatter[mine],
            "lognormal" if avalanches.in_log else "normal",
            len(mine),
            rng,
        )
        if draws.sigma_m is not None:
            site = avalanches.site
            release_x = float(site.release_x[avalanches.release[0]])
            sigma = draws.sigma_m[parameter[mine]]
            x, y, counts[NOT_RELEASED] = scattered_stops(site.smooth, release_x, y, sigma, rng)
        xs.append(x)
        ys.append(y)
        held += int(counts[NOT_RELEASED])
    return bounds_of_stops(np.concatenate(xs), np.concatenate(ys), held, n_draws)


def _alike(group: Indices, kind: Indices) -> list[Indices]:
    """Draws that run by the same tables, group by group and in each kind by kind."""
    key = group * (int(kind.max()) + 1) + kind
    order = np.argsort(key, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(key[order])) + 1)


def _kinds(tables: tuple[Predicted, ...]) -> Indices:
    """A number for each class: those with one number have the same tables."""
    rows = [tuple(row) for row in tables[len(tables) // 2].x.tolist()]
    number = {row: k for k, row in enumerate(sorted(set(rows)))}
    return np.array([number[row] for row in rows], np.int64)
