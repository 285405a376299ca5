"""Recorded volumes and their error: nodes over the log of the true volume of each event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.columns import EventColumns
from avahazard.records.event import Event

Floats = NDArray[np.float64]

N_NODES = 5
MIN_SPREAD = 0.1
"""Smallest natural spread of log volume that is believed."""
MOST_LOG = 700.0
"""Log volumes of the nodes are kept within ± this, where their exponentials are numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNodes:
    """Quadrature over log true volume: `log_volume`, `weight` `[n_events, n_nodes]`.

    Given its record, it is normal with `mean` and `sd` `[n_events]`.

    True volumes of a path are lognormal with mean `centre[path]` (log m3) and standard deviation
    `spread`; the record adds its own error, so large records are on average overestimates and
    are drawn towards the centre. `known` is False where no event has a volume.
    """

    log_volume: Floats
    weight: Floats
    mean: Floats
    sd: Floats
    centre: dict[str, float]
    spread: float
    known: bool


def volume_nodes(
    events: Sequence[Event], columns: EventColumns, population: VolumeNodes | None = None
) -> VolumeNodes:
    """Nodes for each event; one without a volume takes the whole population of its path."""
    recorded = columns.log_volume
    sigma = np.array([e.volume_rel_sigma for e in events])
    have = np.isfinite(recorded)
    if population is None:
        population = _population(recorded, sigma, columns)
    names = [columns.paths[k] if k >= 0 else "" for k in columns.path_index]
    overall = float(np.mean(list(population.centre.values())))
    centre = np.array([population.centre.get(name, overall) for name in names])
    spread2 = population.spread**2
    trust = np.where(have, spread2 / (spread2 + sigma**2), 0.0)
    mean = centre + trust * (np.where(have, recorded, centre) - centre)
    sd = np.sqrt(spread2 * (1.0 - trust))
    z, w = np.polynomial.hermite_e.hermegauss(N_NODES)
    return VolumeNodes(
        log_volume=np.clip(mean[:, None] + sd[:, None] * z, -MOST_LOG, MOST_LOG),
        weight=np.tile(w / np.sum(w), (len(events), 1)),
        mean=np.clip(mean, -MOST_LOG, MOST_LOG),
        sd=sd,
        centre=population.centre,
        spread=population.spread,
        known=population.known,
    )


def _population(recorded: Floats, sigma: Floats, columns: EventColumns) -> VolumeNodes:
    """Centres by path, drawn a little to the overall mean, and one spread, by moments."""
    have = np.isfinite(recorded)
    empty, none = np.empty((0, N_NODES)), np.empty(0)
    if not np.any(have):
        return VolumeNodes(empty, empty, none, none, {"": float(np.log(1e4))}, MIN_SPREAD, False)
    overall = float(np.mean(recorded[have]))
    groups = {-1: ""} | dict(enumerate(columns.paths))
    members = {k: recorded[have & (columns.path_index == k)] for k in groups}
    squares = sum(float(np.sum((v - np.mean(v)) ** 2)) for v in members.values() if len(v))
    free = max(1, int(np.sum(have)) - sum(1 for v in members.values() if len(v)))
    spread2 = max(squares / free - float(np.mean(sigma[have] ** 2)), MIN_SPREAD**2)
    total2 = squares / free
    between2 = max(float(np.var([np.mean(v) for v in members.values() if len(v)])), MIN_SPREAD**2)
    centre = {}
    for k, values in members.items():
        trust = between2 / (between2 + max(total2, spread2) / len(values)) if len(values) else 0.0
        centre[groups[k]] = overall + trust * (float(np.mean(values)) - overall if trust else 0.0)
    return VolumeNodes(empty, empty, none, none, centre, float(np.sqrt(spread2)), True)
