"""Recorded volumes and their error: nodes over the log of the true volume of each event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.inference.model.stand_in import told_by_stand_in
from avahazard.inference.model.volume_population import (
    Population,
    VolumeRecords,
    population_of,
    with_errors,
)
from avahazard.records.event import Event

N_NODES, APART = 11, 0.65
"""Nodes of the true volume, and how many standard deviations of its log lie between two."""
N_BOUNDED = 9
"""Nodes where true volumes have an upper bound: their chances are cut there."""


def even_nodes(n: int, apart: float) -> tuple[Floats, Floats]:
    """Evenly spaced nodes z `[n]` of a normal, `apart`, and weights with its moments up to five.

    A law can be so steep that friction changes between two nodes by more than it scatters: the
    likelihood is then a comb, not the bell that it stands for. The few nodes of Gauss and Hermite
    lie 1.4 apart. Even ones bear a bell as wide as half of `apart` (the trapezoidal rule, Trefethen
    and Weideman 2014, SIAM Review 56, 385); a factor of 1 or nearly that makes up for cut tails.
    """
    z = apart * (np.arange(n) - (n - 1) / 2)
    density = np.exp(-0.5 * z**2)
    powers = z ** np.array([[0.0], [2.0], [4.0]])
    factor = np.linalg.solve((powers * density) @ powers.T, np.array([1.0, 1.0, 3.0]))
    return np.asarray(z, np.float64), np.asarray(density * (factor @ powers), np.float64)


# Made once: a fit to the errors asks for nodes at each of its steps.
NORMAL_Z, NORMAL_W = even_nodes(N_NODES, APART)
CHANCE, CHANCE_W = np.polynomial.legendre.leggauss(N_BOUNDED)
MOST_LOG = 700.0
"""Log volumes of the nodes are kept within ± this, where their exponentials are numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNodes:
    """Quadrature over log true volume: `log_volume`, `weight` `[n_events, n_nodes]`.

    `volume` (m3) is the volume itself, which follows `log_volume`.

    Given its record, it is normal with `mean` and `sd` `[n_events]`, but for the bound.

    The record adds its own error to what is drawn from the `population` of its path, so large
    records are on average overestimates. `records` are what volumes are read from. No true volume
    is over `largest` (m3): above it there is none of the population.
    """

    log_volume: Floats
    volume: Floats = field(init=False)
    weight: Floats
    mean: Floats
    sd: Floats
    records: VolumeRecords
    population: Population
    largest: float = np.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "volume", np.exp(self.log_volume))


def volume_nodes(
    events: Sequence[Event], columns: EventColumns, elsewhere: VolumeNodes | None = None
) -> VolumeNodes:
    """Nodes for each event; one without a volume takes the whole population of its path.

    The population is that of the events, or that from `elsewhere` with errors as stated.
    """
    records = VolumeRecords(
        columns.log_volume,
        np.array([e.volume_rel_sigma for e in events]),
        np.asarray(columns.path_index, np.int64) + 1,
        ("", *columns.paths),
    )
    if elsewhere is None:
        return _nodes(records, population_of(records))
    return _nodes(records, with_errors(elsewhere.population, 1.0))


def rescaled(volumes: VolumeNodes, factor: float) -> VolumeNodes:
    """The same where the errors are `factor` times as large as stated.

    The scatter of the records stays, so that what is error is not natural spread.
    """
    return _nodes(volumes.records, with_errors(volumes.population, factor), volumes.largest)


def bounded(volumes: VolumeNodes, largest: float) -> VolumeNodes:
    """The same where no true volume is over `largest` (m3), whatever the records state."""
    return _nodes(volumes.records, volumes.population, largest)


def told_by(volumes: VolumeNodes, stand_in: Floats) -> VolumeNodes:
    """The same where `stand_in` `[n_events]` tells of the true volumes too (`model.stand_in`)."""
    recorded = volumes.records
    told = told_by_stand_in(recorded.log_volume, stand_in, recorded.path)
    return _nodes(replace(recorded, told=told), volumes.population, volumes.largest)


def _nodes(records: VolumeRecords, population: Population, largest: float = np.inf) -> VolumeNodes:
    """Nodes of records from this population, cut at the `largest` volume (m3) too."""
    mean, sd = population.given(records)
    largest = float(min(largest, np.exp(population.largest)))
    z, w = _within(mean, sd, largest)
    log_volume = np.clip(mean[:, None] + sd[:, None] * z, -MOST_LOG, MOST_LOG)
    return VolumeNodes(
        log_volume=log_volume,
        weight=np.tile(w / np.sum(w), (len(mean), 1)),
        mean=np.clip(mean, -MOST_LOG, MOST_LOG),
        sd=sd,
        records=records,
        population=population,
        largest=largest,
    )


def drawn_log_volumes(volumes: VolumeNodes, z: Floats) -> Floats:
    """Logs of true volumes (m3) for standard normal numbers z `[..., n_events]`."""
    if np.isfinite(volumes.largest):
        z = ndtri_exp(_top(volumes.mean, volumes.sd, volumes.largest) + log_ndtr(z))
    return volumes.mean + volumes.sd * z


def _within(mean: Floats, sd: Floats, largest: float) -> tuple[Floats, Floats]:
    """Nodes z `[..., n_nodes]` of a normal that is cut at log `largest`, and their weights."""
    if np.isinf(largest):
        return NORMAL_Z, NORMAL_W
    top = _top(mean, sd, largest)
    return ndtri_exp(top[:, None] + np.log(0.5 * (CHANCE + 1.0))), CHANCE_W


def _top(mean: Floats, sd: Floats, largest: float) -> Floats:
    """Log of the chance of such normals to lie below log `largest`."""
    return np.asarray(log_ndtr((np.log(largest) - mean) / np.maximum(sd, 1e-9)))
