"""How true volumes of a path are spread about its centre, where a lognormal does not describe it.

Volumes that are written down begin where an avalanche is worth a record, and end where a release
zone is full. What a record of a large volume then tells of the true one differs from what it would
among volumes without an end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, log_softmax, logsumexp

from avahazard.arrays import Floats, Ints
from avahazard.inference.model.friction_scatter import HALF_LOG_2PI

TRIED = np.linspace(0.8, 1.0, 9)
"""Quantiles of the records at which a largest volume is tried; beyond, some of its distance."""
STEPS, CLOSE = 200, 1e-6
WIDEST = 5.0
"""Times the spread of what is recorded that normals have at most."""
MOST_PULL = 2.0
"""Spreads by which the centre of a path whose records crowd at the end is put above their mean."""


class CutNormals(NamedTuple):
    """Normals about `centre` `[n_paths]` of standard deviation `spread`, all cut at `largest`."""

    centre: Floats
    spread: float
    largest: float


def cut_normals(centre: Floats, count: Ints, spread: float, largest: float) -> CutNormals:
    """Normals that have these means and, on the mean of `count` `[n_paths]`, this spread when cut.

    As near as can be: what is cut above is no more skewed than an exponential.
    """
    c, s = centre, spread
    if np.isinf(largest):
        return CutNormals(c, s, largest)
    for _ in range(STEPS):
        z = (largest - c) / s
        pull = np.minimum(np.exp(-0.5 * z**2 - HALF_LOG_2PI - log_ndtr(z)), MOST_PULL)
        share = np.average(1.0 - z * pull - pull**2, weights=count)
        before, c = s, centre + s * pull
        s = spread / np.sqrt(max(share, WIDEST**-2))
        if abs(s - before) < CLOSE * s:
            break
    return CutNormals(c, s, largest)


def largest_volume(
    recorded: Floats, sigma: Floats, path: Ints, centre: Floats, spread: float
) -> tuple[float, float]:
    """The likeliest largest log volume, and its log likelihood ratio over none (nats).

    There is a largest: release zones are full at some time.

    Given log records `[n]`, their errors, the `path` `[n]` of each, and the `centre` `[n_paths]`
    and `spread` of what is recorded, less its errors. The ratio is less half the log of the number
    of records, which is what a parameter costs.
    """
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 (slow to import)

    count = np.bincount(path, minlength=len(centre))
    told = partial(_log_likelihood, recorded, sigma, path, count, centre, spread)
    beyond = recorded.max() + spread * np.array([0.25, 0.5, 1.0, 2.0])
    tried = np.concatenate([np.quantile(recorded, TRIED), beyond])
    found = np.array([told(largest) for largest in tried])
    best = int(np.argmax(found))
    near = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    finer = minimize_scalar(lambda v: -told(v), bounds=near, method="bounded")
    largest = float(finer.x if -finer.fun > found[best] else tried[best])
    return largest, float(max(-finer.fun, found[best]) - told(np.inf) - 0.5 * np.log(len(recorded)))


def _log_likelihood(
    recorded: Floats,
    sigma: Floats,
    path: Ints,
    count: Ints,
    centre: Floats,
    spread: float,
    largest: float,
) -> float:
    """Log likelihood of the records where no true volume is over the `largest` (log)."""
    cut = cut_normals(centre, count, spread, largest)
    middle, total2 = cut.centre[path], cut.spread**2 + sigma**2
    away = recorded - middle
    mean = middle + away * cut.spread**2 / total2
    sd = np.maximum(cut.spread * sigma / np.sqrt(total2), 1e-9)
    seen = log_ndtr((largest - mean) / sd) - log_ndtr((largest - middle) / cut.spread)
    return float(np.sum(seen - 0.5 * (np.log(total2) + away**2 / total2)))


STEP, BEYOND = 0.25, 1.0
"""Between two points of the density, and from the outermost record to its end, in spreads."""
FARTHEST = 8.0
"""Spreads from the centre within which the density is asked for."""
LEAST_ERROR = 0.15
"""Smaller errors, in spreads, hardly move what is drawn, and count as this."""
SMOOTHNESS = 10.0 ** np.arange(-1.0, 6.5, 0.5)
"""Weights of the penalty that are tried; with the largest the density is normal."""
WINDOW, WITHIN = 8.0, 65
"""Standard deviations either way over which a true volume is looked for, and points there."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeShape:
    """Log density `log_density` at `away` `[n_points]`, with mean 0 and standard deviation 1.

    `away` is the log of a true volume over the centre of its path, in spreads.
    """

    away: Floats
    log_density: Floats

    def moments(self, recorded: Floats, error: Floats) -> tuple[Floats, Floats]:
        """Mean and standard deviation of true values `[n]`, given records and their errors.

        All in spreads from the centre; errors are normal and more than 0.
        """
        trust = 1.0 / (1.0 + error**2)
        # About what a normal would give, and as far as that is wide.
        z = np.linspace(-WINDOW, WINDOW, WITHIN)
        true = (trust * recorded)[:, None] + (np.sqrt(trust) * error)[:, None] * z
        logs = self._at(true) - 0.5 * ((true - recorded[:, None]) / error[:, None]) ** 2
        weight = np.exp(logs - logs.max(axis=1, keepdims=True))
        weight /= weight.sum(axis=1, keepdims=True)
        mean = np.sum(weight * true, axis=1)
        variance = np.sum(weight * (true - mean[:, None]) ** 2, axis=1)
        return mean, np.sqrt(variance)

    def _at(self, true: Floats) -> Floats:
        """Log density; beyond the ends it goes on falling as it did last."""
        logs = np.interp(true, self.away, self.log_density)
        slope = np.diff(self.log_density)[[0, -1]] / np.diff(self.away)[[0, -1]]
        logs += max(slope[0], 0.0) * np.minimum(true - self.away[0], 0.0)
        logs += min(slope[1], 0.0) * np.maximum(true - self.away[-1], 0.0)
        return np.asarray(logs)


def volume_shape(recorded: Floats, error: Floats) -> tuple[VolumeShape, float]:
    """The likeliest shape, and its log evidence over that of a normal (nats).

    Given records `[n]` with normal errors, both in spreads from the centre. Log density bends as
    little as it can: its third derivative is penalised, so that what it is drawn to is a normal
    (Silverman 1982, Annals of Statistics 10, 795). The weight of the penalty is the likeliest one,
    the density integrated out by Laplace's method; the errors are taken out as in Efron (2016),
    Biometrika 103, 1.
    """
    low, high = np.clip([recorded.min() - BEYOND, recorded.max() + BEYOND], -FARTHEST, FARTHEST)
    away = np.linspace(low, high, max(int(np.ceil((high - low) / STEP)), 8) + 1)
    chance, count = _chances(recorded, np.maximum(error, LEAST_ERROR), away)
    bends = np.diff(np.eye(len(away)), 3, axis=0) / (away[1] - away[0]) ** 2.5
    penalty = bends.T @ bends
    start = -0.5 * away**2
    likeliest, at_normal, shape = -np.inf, np.nan, start
    for weight in SMOOTHNESS[::-1]:
        start, evidence = _fit(start, chance, count, weight * penalty)
        if np.isnan(at_normal):
            at_normal = evidence
        if evidence > likeliest:
            likeliest, shape = evidence, start
    return _standardised(away, shape), likeliest - at_normal


def _chances(recorded: Floats, error: Floats, away: Floats) -> tuple[Floats, Floats]:
    """Log chance of records given what is true, `[n_rows, n_points]`, and how many each row has.

    Records that differ by less than a tenth of their error stand together.
    """
    log_error = np.round(np.log(error) * 10.0) / 10.0
    alike = np.exp(log_error)
    place = np.round(recorded / (0.1 * alike)) * 0.1 * alike
    rows, count = np.unique(np.column_stack([place, alike]), axis=0, return_counts=True)
    z = (rows[:, :1] - away) / rows[:, 1:]
    return -0.5 * z**2 - np.log(rows[:, 1:]), count.astype(np.float64)


def _fit(start: Floats, chance: Floats, count: Floats, penalty: Floats) -> tuple[Floats, float]:
    """Log density `[n_points]`, up to a constant, and the log marginal likelihood."""
    from scipy.optimize import minimize  # noqa: PLC0415 (slow to import)

    told = partial(_loss, chance=chance, count=count, penalty=penalty)
    bend = partial(_curvature, chance=chance, count=count, penalty=penalty)
    found = minimize(told, start, jac=True, hess=bend, method="trust-exact")
    values, n = np.linalg.eigvalsh(penalty), len(penalty)
    curvature = np.linalg.slogdet(bend(found.x) + np.ones((n, n)))[1]
    # Constants, lines and parabolas cost nothing.
    evidence = -found.fun + 0.5 * float(np.sum(np.log(values[3:]))) - 0.5 * float(curvature)
    return np.asarray(found.x), evidence


def _loss(eta: Floats, chance: Floats, count: Floats, penalty: Floats) -> tuple[float, Floats]:
    """Minus the penalised log likelihood, and its slope."""
    log_share = log_softmax(eta)
    logs = chance + log_share
    total = logsumexp(logs, axis=1, keepdims=True)
    expected = count @ np.exp(logs - total)
    bent = penalty @ eta
    loss = -count @ total[:, 0] + 0.5 * eta @ bent
    return float(loss), np.asarray(count.sum() * np.exp(log_share) - expected + bent)


def _curvature(eta: Floats, chance: Floats, count: Floats, penalty: Floats) -> Floats:
    """Curvature of `_loss`."""
    log_share = log_softmax(eta)
    share, logs = np.exp(log_share), chance + log_share
    given = np.exp(logs - logsumexp(logs, axis=1, keepdims=True))
    of_all = count.sum() * (np.diag(share) - np.outer(share, share))
    of_records = np.diag(count @ given) - (given.T * count) @ given
    return np.asarray(of_all - of_records + penalty)


def _standardised(away: Floats, log_density: Floats) -> VolumeShape:
    """With mean 0 and standard deviation 1: these are told by the records' own moments."""
    share = np.exp(log_softmax(log_density))
    mean = float(share @ away)
    spread = float(np.sqrt(share @ (away - mean) ** 2))
    return VolumeShape((away - mean) / spread, log_softmax(log_density))
