"""Recorded volumes and their error: nodes over the log of the true volume of each event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import EventColumns
from avahazard.effects.volume_spread import MIN_SPREAD, variance_within
from avahazard.inference.model.stand_in import told_by_stand_in
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
class VolumeRecords:
    """What is written of volumes, each `[n_events]`: `log_volume` (log m3, or nan).

    `sigma` is its stated error, `path` the place of its path among the `paths`, of which the first,
    '', is none. `told` is what something else that goes with the volume tells of it
    (`told_by_stand_in`), where that is asked.
    """

    log_volume: Floats
    sigma: Floats
    path: Ints
    paths: tuple[str, ...]
    told: Floats | None = None

    def by_path(self) -> list[Floats]:
        """The recorded log volumes of each of the `paths`, those that are known."""
        have = np.isfinite(self.log_volume)
        path = self.path[have]
        ends = np.cumsum(np.bincount(path, minlength=len(self.paths)))
        return np.split(self.log_volume[have][np.argsort(path, kind="stable")], ends[:-1])


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNodes:
    """Quadrature over log true volume: `log_volume`, `weight` `[n_events, n_nodes]`.

    `volume` (m3) is the volume itself.

    Given its record, it is normal with `mean` and `sd` `[n_events]`, but for the bound.

    True volumes of a path are lognormal with mean `centre[path]` (log m3) and standard deviation
    `spread`; the record adds its own error, so large records are on average overestimates and
    are drawn towards the centre. `known` is False where no event has a volume. `records` are what
    they are read from, `reference` those that centre and spread come from, with `factor` times
    their stated errors. No true volume is over `largest` (m3): above it there is none of the
    population.
    """

    log_volume: Floats
    volume: Floats
    weight: Floats
    mean: Floats
    sd: Floats
    centre: dict[str, float]
    spread: float
    known: bool
    records: VolumeRecords
    reference: VolumeRecords
    factor: float = 1.0
    largest: float = np.inf


def volume_nodes(
    events: Sequence[Event], columns: EventColumns, population: VolumeNodes | None = None
) -> VolumeNodes:
    """Nodes for each event; one without a volume takes the whole population of its path."""
    records = VolumeRecords(
        columns.log_volume,
        np.array([e.volume_rel_sigma for e in events]),
        np.asarray(columns.path_index, np.int64) + 1,
        ("", *columns.paths),
    )
    if population is None:
        return _nodes(records, records, 1.0)
    known = None if population.factor != 1.0 else population
    return _nodes(records, population.reference, 1.0, known)


def rescaled(volumes: VolumeNodes, factor: float) -> VolumeNodes:
    """The same where the errors are `factor` times as large as stated.

    The scatter of the records stays, so that what is error is not natural spread.
    """
    return _nodes(volumes.records, volumes.reference, factor, largest=volumes.largest)


def bounded(volumes: VolumeNodes, largest: float) -> VolumeNodes:
    """The same where no true volume is over `largest` (m3), whatever the records state."""
    return _nodes(volumes.records, volumes.reference, volumes.factor, largest=largest)


def told_by(volumes: VolumeNodes, stand_in: Floats) -> VolumeNodes:
    """The same where `stand_in` `[n_events]` tells of the true volumes too (`model.stand_in`)."""
    recorded = volumes.records
    told = told_by_stand_in(recorded.log_volume, stand_in, recorded.path)
    records = replace(recorded, told=told)
    return _nodes(records, volumes.reference, volumes.factor, volumes, volumes.largest)


def _nodes(
    records: VolumeRecords,
    reference: VolumeRecords,
    factor: float,
    alike: VolumeNodes | None = None,
    largest: float = np.inf,
) -> VolumeNodes:
    """Nodes by the population of `reference`, which `alike` has already."""
    recorded, sigma = records.log_volume, factor * records.sigma
    have = np.isfinite(recorded)
    if alike is None:
        centres, spread, known = _population(reference, factor * reference.sigma)
    else:
        centres, spread, known = alike.centre, alike.spread, alike.known
    overall = float(np.mean(list(centres.values())))
    centre = np.array([centres.get(name, overall) for name in records.paths])[records.path]
    spread2 = np.full(len(centre), spread**2)
    if records.told is not None:
        told = records.told
        some = np.isfinite(told)
        centre[some] += told[some]
        # What is told is no spread any more.
        explained = float(np.mean(told[some] ** 2)) if np.any(some) else 0.0
        spread2[some] = max(spread**2 - explained, MIN_SPREAD**2)
    trust = np.where(have, spread2 / (spread2 + sigma**2), 0.0)
    mean = centre + trust * (np.where(have, recorded, centre) - centre)
    sd = np.sqrt(spread2 * (1.0 - trust))
    z, w = _within(mean, sd, largest)
    log_volume = np.clip(mean[:, None] + sd[:, None] * z, -MOST_LOG, MOST_LOG)
    return VolumeNodes(
        log_volume=log_volume,
        volume=np.exp(log_volume),
        weight=np.tile(w / np.sum(w), (len(recorded), 1)),
        mean=np.clip(mean, -MOST_LOG, MOST_LOG),
        sd=sd,
        centre=centres,
        spread=spread,
        known=known,
        records=records,
        reference=reference,
        factor=factor,
        largest=largest,
    )


def _within(mean: Floats, sd: Floats, largest: float) -> tuple[Floats, Floats]:
    """Nodes z `[..., n_nodes]` of a normal that is cut at log `largest`, and their weights."""
    if np.isinf(largest):
        return NORMAL_Z, NORMAL_W
    top = log_ndtr((np.log(largest) - mean) / np.maximum(sd, 1e-9))
    return ndtri_exp(top[:, None] + np.log(0.5 * (CHANCE + 1.0))), CHANCE_W


def _population(records: VolumeRecords, sigma: Floats) -> tuple[dict[str, float], float, bool]:
    """Centres by path, drawn a little to the overall mean, and one spread, by moments.

    Last, whether any volume is known.
    """
    recorded = records.log_volume
    have = np.isfinite(recorded)
    if not np.any(have):
        return {"": float(np.log(1e4))}, MIN_SPREAD, False
    overall = float(np.mean(recorded[have]))
    members = dict(zip(records.paths, records.by_path(), strict=True))
    total2 = variance_within(list(members.values()))
    spread2 = max(total2 - float(np.mean(sigma[have] ** 2)), MIN_SPREAD**2)
    between2 = max(float(np.var([np.mean(v) for v in members.values() if len(v)])), MIN_SPREAD**2)
    centre = {}
    for name, values in members.items():
        trust = between2 / (between2 + max(total2, spread2) / len(values)) if len(values) else 0.0
        centre[name] = overall + trust * (float(np.mean(values)) - overall if trust else 0.0)
    return centre, float(np.sqrt(spread2)), True
