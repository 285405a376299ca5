"""Annual chances in the cells of a path's terrain, from runs of a flow model over friction and V.

For each cell and volume there is a friction under which an avalanche exceeds a pressure there: it
lies between the runs that do and do not. The chance of an avalanche is that of a lower friction by
the calibrated P[μ|V], mixed over the volumes, as along a line; no run is drawn anew.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.hazard.exceedance import Avalanches, friction_below
from avahazard.records.collection import Simulation

MOST_DRAWS = 60
"""Posterior draws over which a map is spread."""
ALWAYS = 5.0
"""The friction of a cell in which the run of most friction still exceeds a pressure."""
CELLS_AT_ONCE = 64
LEVELS = (0.05, 0.95)


@dataclass(frozen=True, slots=True, eq=False)
class FrictionField:
    """Under which friction each cell is exceeded: `friction` `[n_volumes, n_cells]`, 0 for never.

    `log_volume` `[n_volumes]` (log m3) rise. `lowest` and `highest` `[n_volumes]` are the ends of
    the frictions of the runs.
    """

    log_volume: Floats
    friction: Floats
    lowest: Floats
    highest: Floats

    def at(self, log_volume: Floats) -> Floats:
        """The same at other volumes `[n]`, straight in their log: `[n, n_cells]`.

        Where only one of two neighbours is never or always exceeded, the end of its runs counts, as
        in a table of stops.
        """
        place = np.interp(log_volume, self.log_volume, np.arange(len(self.log_volume)))
        low = np.minimum(place.astype(np.int64), max(len(self.log_volume) - 2, 0))
        high = np.minimum(low + 1, len(self.log_volume) - 1)
        ends = self.lowest[:, None], self.highest[:, None]
        inside = np.clip(self.friction, *ends)
        share = (place - low)[:, None]
        mixed = (1.0 - share) * inside[low] + share * inside[high]
        first, second = self.friction[low], self.friction[high]
        alike = (first == second) & ((first == 0.0) | (first == ALWAYS))
        whole = np.where(share < 1.0, first, second)
        return np.where(alike | (share == 0.0) | (share == 1.0), whole, mixed)


def friction_field(
    simulations: Sequence[Simulation], place: Floats, limit_kpa: float
) -> FrictionField:
    """The field of a limit of peak pressure (kPa), from runs with their peaks.

    `place` `[n_rows, n_columns]` (m) is where along the line each cell lies. Between a run that
    exceeds the limit in a cell and one that does not even come there, the front goes straight from
    one stop to the other in friction, as along the line; beside it, the pressure.
    """
    ordered = sorted(simulations, key=lambda s: (s.volume_m3, s.friction))
    of_volume = {v: list(runs) for v, runs in groupby(ordered, key=lambda s: s.volume_m3)}
    rows = [_of_volume(runs, place.ravel(), limit_kpa) for runs in of_volume.values()]
    ends = [(runs[0].friction, runs[-1].friction) for runs in of_volume.values()]
    return FrictionField(np.log(list(of_volume)), np.array(rows), *np.array(ends).T)


def _of_volume(runs: Sequence[Simulation], place: Floats, limit: float) -> Floats:
    """Friction `[n_cells]` of one volume, whose `runs` rise in friction."""
    mu = np.array([run.friction for run in runs])
    peak = np.array([run.peak_kpa for run in runs], np.float64).reshape(len(runs), -1)
    # More friction never presses more: what the cells leave of it is noise.
    peak = np.maximum.accumulate(peak[::-1], axis=0)[::-1]
    over = peak > limit
    n_over = np.count_nonzero(over, axis=0)
    found = np.where(n_over == len(mu), ALWAYS, 0.0)
    known = np.isfinite(place)
    stop = [float(np.max(place[row & known], initial=-np.inf)) for row in over]
    for k in range(len(mu) - 1):
        here = np.flatnonzero(n_over == k + 1)
        share = (peak[k, here] - limit) / np.maximum(peak[k, here] - peak[k + 1, here], 1e-12)
        ahead = place[here] > stop[k + 1]
        if np.isfinite(stop[k + 1]):
            way = (stop[k] - place[here]) / max(stop[k] - stop[k + 1], 1e-9)
            share = np.where(ahead, way, share)
        found[here] = mu[k] + np.clip(share, 0.0, 1.0) * (mu[k + 1] - mu[k])
    return found


def annual_chance(avalanches: Avalanches, field: FrictionField) -> Floats:
    """Chance in a year `[3, n_cells]`: the mean over the parameters, its 5 and its 95 %."""
    some = np.unique(np.linspace(0, avalanches.n_parameters - 1, MOST_DRAWS).astype(np.int64))
    part = _part(avalanches, some)
    n_kinds = part.kind_share.shape[1]
    at_nodes = np.tile(field.at(part.volumes.log_volume), (n_kinds, 1)).T
    result = np.zeros((3, field.friction.shape[1]))
    cells = np.flatnonzero(field.friction.max(axis=0) > 0.0)
    for first in range(0, len(cells), CELLS_AT_ONCE):
        selected = cells[first : first + CELLS_AT_ONCE]
        chance = friction_below(part, at_nodes[selected][:, None, None, :])
        rate = np.einsum("xpcv,pv,c->xp", chance, part.share, part.class_share)
        yearly = -np.expm1(-part.volumes.rate * rate)
        result[0, selected] = yearly.mean(axis=1)
        result[1:, selected] = np.quantile(yearly, LEVELS, axis=1)
    return result


def _part(avalanches: Avalanches, draws: Ints) -> Avalanches:
    """The same with some of its draws, and one class where all are alike in their friction."""
    part = avalanches.of_draws(lambda values: values[draws], avalanches.group[draws])
    location, scatter = part.location, part.scatter
    if np.any(np.ptp(location, axis=1)) or np.any(np.ptp(scatter, axis=1)):
        return part
    return replace(part, location=location[:, :1], scatter=scatter[:, :1], class_share=np.ones(1))
