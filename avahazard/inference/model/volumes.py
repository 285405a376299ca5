"""Recorded volumes and their error: nodes over the log of the true volume of each event."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from scipy.special import log_ndtr, ndtri_exp

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import EventColumns
from avahazard.effects.record import MIN_SPREAD, variance_within
from avahazard.inference.model.friction_model import HALF_LOG_2PI
from avahazard.records.collection import Event

TRIED = np.linspace(0.8, 1.0, 9)
"""Quantiles of the records at which a largest volume is tried; beyond, some of its distance."""
STEPS, CLOSE = 200, 1e-6
WIDEST = 5.0
"""Times the spread of what is recorded that normals have at most."""
MOST_PULL = 2.0
"""Spreads by which the centre of a path whose records crowd at the end is put above their mean."""


def cut_normals(centre: Floats, count: Ints, spread: float, largest: float) -> tuple[Floats, float]:
    """Centres `[n_paths]` and spread of normals that have these when they are cut at `largest`.

    The spread is that on the mean of `count` `[n_paths]`. As near as can be: what is cut above is
    no more skewed than an exponential.
    """
    c, s = centre, spread
    if np.isinf(largest):
        return c, s
    for _ in range(STEPS):
        z = (largest - c) / s
        pull = np.minimum(np.exp(-0.5 * z**2 - HALF_LOG_2PI - log_ndtr(z)), MOST_PULL)
        share = np.average(1.0 - z * pull - pull**2, weights=count)
        before, c = s, centre + s * pull
        s = spread / np.sqrt(max(share, WIDEST**-2))
        if abs(s - before) < CLOSE * s:
            break
    return c, s


def largest_volume(
    recorded: Floats, sigma: Floats, path: Ints, centre: Floats, spread: float
) -> tuple[float, float]:
    """The likeliest largest log volume, and its log likelihood ratio over none (nats).

    Given log records `[n]`, their errors, the `path` `[n]` of each, and the `centre` `[n_paths]`
    and `spread` of what is recorded, less its errors. The ratio is less half the log of the number
    of records, which is what a parameter costs.
    """
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 (slow to import)

    count = np.bincount(path, minlength=len(centre))

    def told(largest: float) -> float:
        """Log likelihood of the records where no true volume is over the `largest` (log)."""
        centres, width = cut_normals(centre, count, spread, largest)
        middle, total2 = centres[path], width**2 + sigma**2
        away = recorded - middle
        mean = middle + away * width**2 / total2
        sd = np.maximum(width * sigma / np.sqrt(total2), 1e-9)
        seen = log_ndtr((largest - mean) / sd) - log_ndtr((largest - middle) / width)
        return float(np.sum(seen - 0.5 * (np.log(total2) + away**2 / total2)))

    beyond = recorded.max() + spread * np.array([0.25, 0.5, 1.0, 2.0])
    tried = np.concatenate([np.quantile(recorded, TRIED), beyond])
    found = np.array([told(largest) for largest in tried])
    best = int(np.argmax(found))
    near = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    finer = minimize_scalar(lambda v: -told(v), bounds=near, method="bounded")
    largest = float(finer.x if -finer.fun > found[best] else tried[best])
    return largest, float(max(-finer.fun, found[best]) - told(np.inf) - 0.5 * np.log(len(recorded)))


def told_by_stand_in(log_volume: Floats, stand_in: Floats, path: Ints) -> Floats:
    """Log true volume over its path's mean, from `stand_in`, all `[n_events]`; nan if unknown.

    By the line of least squares through what events have of both, less the means of their paths
    (`path` `[n_events]`). Errors of recorded volumes do not bend it: they scatter about it.
    """
    away = within_paths(np.array([stand_in, log_volume]), path)
    known = np.isfinite(away).all(axis=0)
    squares = float(np.sum(away[0, known] ** 2))
    if squares == 0.0:
        return np.full(len(path), np.nan)
    return np.asarray(away[0] * (float(away[0, known] @ away[1, known]) / squares))


def within_paths(pair: Floats, path: Ints) -> Floats:
    """Both rows `[2, n_events]` less their means on each `path` of two events with both; or nan."""
    both = np.isfinite(pair).all(axis=0)
    away = np.full(pair.shape, np.nan)
    for k in np.unique(path):
        selected = path == k
        if np.sum(both & selected) > 1:
            away[:, selected] = pair[:, selected] - pair[:, both & selected].mean(
                axis=1, keepdims=True
            )
    return away


NEEDED = 5.0
"""Nats by which a population with a largest volume must exceed one without."""
LEAST_SPREAD = 0.5
"""Root mean square errors that true volumes must spread over for anything else to be estimated."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeRecords:
    """What is written of volumes, each `[n_events]`: `log_volume` (log m3, or nan).

    `sigma` is its stated error, `path` the place of its path among the `paths`, of which the first,
    '', is none. `told` is what a column that is correlated with the volume indicates of it
    (`told_by_stand_in`), where that is asked.
    """

    log_volume: Floats
    sigma: Floats
    path: Ints
    paths: tuple[str, ...]
    told: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """True volumes of a path are lognormal about its `centre` (log m3), with this `spread`.

    They are cut at the `largest` (log m3) that there is. `known` is False where no event has a
    volume. All are estimated from `records`, with `factor` times their stated errors.
    """

    records: VolumeRecords
    factor: float
    centre: dict[str, float]
    spread: float
    known: bool
    largest: float = np.inf

    def given(self, records: VolumeRecords) -> tuple[Floats, Floats]:
        """Mean and sd of log true volumes, not cut yet, given what is written of each event."""
        recorded, sigma = records.log_volume, self.factor * records.sigma
        have = np.isfinite(recorded)
        centre = self.centres(records.paths)[records.path]
        spread2 = np.full(len(have), self.spread**2)
        if records.told is not None:
            some = np.isfinite(records.told)
            centre[some] += records.told[some]
            # The indicated part is no spread.
            explained = float(np.mean(records.told[some] ** 2)) if np.any(some) else 0.0
            spread2[some] = max(self.spread**2 - explained, MIN_SPREAD**2)
        trust = np.where(have, spread2 / (spread2 + sigma**2), 0.0)
        mean = centre + trust * (np.where(have, recorded, centre) - centre)
        return mean, np.sqrt(spread2 * (1.0 - trust))

    def centres(self, paths: Sequence[str]) -> Floats:
        """The centres of `paths`; of one that is not known the mean of all."""
        overall = float(np.mean(list(self.centre.values())))
        return np.array([self.centre.get(name, overall) for name in paths])


def population_of(records: VolumeRecords) -> Population:
    """Centres, drawn a little to the overall mean, and one spread, by moments; perhaps cut."""
    found = _by_moments(records, 1.0)
    if not found.known or found.spread == MIN_SPREAD:
        return found
    have = np.isfinite(records.log_volume)
    recorded, sigma, path = records.log_volume[have], records.sigma[have], records.path[have]
    if found.spread < LEAST_SPREAD * float(np.sqrt(np.mean(sigma**2))):
        return found
    centre = found.centres(records.paths)
    largest, gain = largest_volume(recorded, sigma, path, centre, found.spread)
    return found if gain < NEEDED else _cut(found, largest)


@lru_cache(maxsize=2)
def with_errors(population: Population, factor: float) -> Population:
    """The same where records' errors are `factor` times as large as stated.

    Their scatter stays, and the largest volume. The last are kept: every path of a region is read
    in the light of the same.
    """
    if population.factor == factor:
        return population
    return _cut(_by_moments(population.records, factor), population.largest)


def _cut(found: Population, largest: float) -> Population:
    """What gives these moments where it is cut at the `largest` volume."""
    records = found.records
    have = np.isfinite(records.log_volume)
    count = np.bincount(records.path[have], minlength=len(records.paths))
    centres, spread = cut_normals(found.centres(records.paths), count, found.spread, largest)
    centre = dict(zip(records.paths, centres.tolist(), strict=True))
    return replace(found, centre=centre, spread=spread, largest=largest)


def _by_moments(records: VolumeRecords, factor: float) -> Population:
    """Centres and spread, where records have `factor` times their stated errors."""
    recorded, sigma = records.log_volume, factor * records.sigma
    have = np.isfinite(recorded)
    if not np.any(have):
        nowhere = {"": float(np.log(1e4))}
        return Population(records, factor, nowhere, MIN_SPREAD, known=False)
    overall, path = float(np.mean(recorded[have])), records.path[have]
    ends = np.cumsum(np.bincount(path, minlength=len(records.paths)))
    members = np.split(recorded[have][np.argsort(path, kind="stable")], ends[:-1])
    total2 = variance_within(members)
    spread2 = max(total2 - float(np.mean(sigma[have] ** 2)), MIN_SPREAD**2)
    between2 = max(float(np.var([np.mean(v) for v in members if len(v)])), MIN_SPREAD**2)
    centre = {}
    for name, values in zip(records.paths, members, strict=True):
        trust = between2 / (between2 + max(total2, spread2) / len(values)) if len(values) else 0.0
        centre[name] = overall + trust * (float(np.mean(values)) - overall if trust else 0.0)
    return Population(records, factor, centre, float(np.sqrt(spread2)), known=True)


N_NODES, APART = 11, 0.65
"""Nodes of the true volume, and how many standard deviations of its log lie between two."""
N_BOUNDED = 9
"""Nodes where true volumes have an upper bound: their chances are cut there."""


def even_nodes(n: int, apart: float) -> tuple[Floats, Floats]:
    """Evenly spaced nodes z `[n]` of a normal, `apart`, and weights with its moments up to five.

    A law can be so steep that friction changes between two nodes by more than it scatters, as
    between the few nodes of Gauss and Hermite, 1.4 apart: the likelihood is then a comb.
    Equidistant ones resolve a normal as wide as half of `apart` (the trapezoidal rule, Trefethen
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

    `volume` (m3) is the volume itself. Given its record, its log is normal with `mean` and `sd`
    `[n_events]`, but for the bound: none is over `largest` (m3). The record adds its own error to
    what is drawn from the `population` of its path, so large records are on average overestimates.
    `records` are what volumes are read from.
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
    """The same with errors `factor` times as large as stated; the scatter of the records stays."""
    return _nodes(volumes.records, with_errors(volumes.population, factor), volumes.largest)


def bounded(volumes: VolumeNodes, largest: float) -> VolumeNodes:
    """The same where no true volume is over `largest` (m3), whatever the records state."""
    return _nodes(volumes.records, volumes.population, largest)


def told_by(volumes: VolumeNodes, stand_in: Floats) -> VolumeNodes:
    """The same where `stand_in` `[n_events]` informs about the true volumes too."""
    recorded = volumes.records
    told = told_by_stand_in(recorded.log_volume, stand_in, recorded.path)
    return _nodes(replace(recorded, told=told), volumes.population, volumes.largest)


def _nodes(records: VolumeRecords, population: Population, largest: float = np.inf) -> VolumeNodes:
    """Nodes of records from this population, cut at the `largest` volume (m3) too."""
    mean, sd = population.given(records)
    largest = float(min(largest, np.exp(population.largest)))
    z, w = NORMAL_Z, NORMAL_W
    if np.isfinite(largest):  # their chances are cut there
        z = ndtri_exp(_top(mean, sd, largest)[:, None] + np.log(0.5 * (CHANCE + 1.0)))
        w = CHANCE_W
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


def _top(mean: Floats, sd: Floats, largest: float) -> Floats:
    """Log of the chance of such normals to lie below log `largest`."""
    return np.asarray(log_ndtr((np.log(largest) - mean) / np.maximum(sd, 1e-9)))
