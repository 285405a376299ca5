"""Which candidate effects the data ask for, against what chance alone would show.

The gain of a candidate is what the quick fit's log likelihood rises when it is added, law,
scatter and path offsets fitted again. Its null distribution comes from worlds made on the user's
own design in which the model is true. A gain is turned into a p-value of its own by a gamma
distribution fitted to the made worlds, and the smallest of these into a family-wise one by
their distribution over the made worlds (Westfall and Young 1993).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from avahazard.criticism.bumps import bumps
from avahazard.criticism.made_worlds import Measured, make_world, real_world
from avahazard.criticism.quick_fit import Design, Edges, QuickFit, quick_fit
from avahazard.criticism.variants import (
    LOG_MU,
    Tables,
    Variant,
    base_coordinates,
    base_design,
    make_tables,
    variants_of,
)
from avahazard.effects.effect import Definition
from avahazard.inference.posterior import Posterior
from avahazard.inference.predicted import predict_records, run_blocks
from avahazard.inference.seeds import generator
from avahazard.inference.study import PLACE, Study

Floats = NDArray[np.float64]

N_WORKERS = 2
BATCH = 40
"""Worlds made before it is asked whether more are needed."""
LEVEL = 0.05
"""Family-wise level of the candidates."""
PATH_LEVEL = 0.01
"""Level of the path effect, tested by itself."""


@dataclass(frozen=True, slots=True)
class Screened:
    """A candidate after the screening: its gain (nats), its p-values by itself and family-wise,
    and the gain that it has in one of twenty worlds where nothing is missing, and on average."""

    definition: Definition
    gain: float
    p_single: float
    p_family: float
    null_gain: float
    null_mean: float


@dataclass(frozen=True, slots=True)
class Screening:
    """All candidates, best first; the gain of the path effect with its p-value; and the gain
    of one parameter that chance exceeds in 5 % of made worlds with some candidate."""

    candidates: tuple[Screened, ...]
    path_gain: float
    path_p: float
    critical_gain: float
    n_worlds: int


def screen(
    posterior: Posterior,
    u: Floats,
    tau: float,
    candidates: Sequence[Definition],
    *,
    n_worlds: int = 199,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _share: None,
) -> Screening:
    """Screen the candidates on a model at its mode u (without path effect), with `tau` the
    spread of path offsets that is granted as a nuisance (0: none granted).

    At most `n_worlds` worlds are made, fewer where it is soon plain that chance does as well
    (the sequential test of Besag and Clifford 1991, whose p-values stay valid). Equal seeds give
    equal results for any number of workers.
    """
    study = posterior.study
    speed_slot = posterior.layout.speed_scatter
    speed_scatter = 0.0 if speed_slot is None else float(np.exp(u[speed_slot]))
    values, curvature = (
        posterior.layout.effect_values(u),
        float(posterior.specification.centrifugal),
    )
    runs = run_blocks(study, posterior.effects, values, curvature)
    predicted = predict_records(study, posterior.effects, values, curvature, runs)
    base = make_tables(study, predicted, study.limit, speed_scatter)
    design = base_design(posterior, u, path_offsets=tau > 0.0)
    bare = design._replace(n_paths=0)
    coefficients = base_coordinates(posterior, u)
    variants: list[Variant] = []
    for k, entry in enumerate(candidates):
        variants += variants_of(
            entry, posterior, u, base, design, coefficients, speed_scatter, runs
        )
        progress(0.3 * (k + 1) / len(candidates))
    keys = [c.key for c in candidates]
    log_scatter = float(u[posterior.layout.scatter])
    student = posterior.specification.tails == "student"
    screener = _Screener(
        base, design, variants, keys, coefficients, log_scatter, tau, student, study
    )

    real = screener.gains(real_world(posterior))
    real_path = 0.0
    if tau > 0.0:
        real_path = screener.path_gain(real_world(posterior), bare)

    def one(b: int) -> tuple[Floats, float]:
        rng = generator(seed, "screening", b)
        gains = screener.gains(make_world(posterior, predicted, u, tau, speed_scatter, rng))
        path = 0.0
        if tau > 0.0:
            flat = make_world(posterior, predicted, u, 0.0, speed_scatter, rng)
            path = screener.path_gain(flat, bare)
        return gains, path

    null, null_path = np.empty((0, len(keys))), np.empty(0)
    with ThreadPoolExecutor(N_WORKERS) as pool:
        while len(null) < n_worlds:
            batch = range(len(null), min(len(null) + BATCH, n_worlds))
            made = list(pool.map(one, batch))
            null = np.concatenate([null, [gains for gains, _ in made]])
            null_path = np.concatenate([null_path, [path for _, path in made]])
            found = _judge(candidates, real, null, real_path, null_path)
            progress(0.3 + 0.7 * len(null) / n_worlds)
            if _plain(found, n_worlds):
                break
    return found


def _plain(found: Screening, n_worlds: int) -> bool:
    """Whether chance is plainly enough: twice as many made worlds have exceeded the records as
    could in all of them if these were to be significant."""
    best = found.candidates[0].p_family if found.candidates else 1.0
    return all(
        p * (found.n_worlds + 1) > 1.0 + 2.0 * level * (n_worlds + 1)
        for p, level in ((best, LEVEL), (found.path_p, PATH_LEVEL))
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Screener:
    """Gains of all candidates on one world."""

    base: Tables
    design: Design
    variants: list[Variant]
    keys: list[str]
    coefficients: Floats
    log_scatter: float
    tau: float
    student: bool
    study: Study

    def gains(self, measured: Measured) -> Floats:
        """Gain of every candidate `[n_candidates]` on one world."""
        reference = self._fit(self.base, self.design, measured, self.coefficients)
        best = np.zeros(len(self.keys))
        place = {key: k for k, key in enumerate(self.keys)}
        summaries = {id(self.base): bumps_of(self.base, measured, self.study.sigma)}
        for variant in self.variants:
            summary = summaries.get(id(variant.tables))
            if summary is None:
                summary = bumps_of(variant.tables, measured, self.study.sigma)
            width = variant.design.x.shape[1]
            start = np.zeros(width)
            shared = min(width, len(reference.coefficients))
            if variant.key == "volume-law":
                start = variant.design.prior_mean.copy()
            else:
                start[:shared] = reference.coefficients[:shared]
            edges = variant.tables.edges
            if variant.margin is not None:
                edges = sight_edges(variant, measured, self.study)
            fit = quick_fit(
                summary,
                measured.left,
                edges,
                variant.design,
                start,
                reference.log_scatter,
                max(reference.tau, 1e-3),
                self.student,
            )
            gain = fit.log_likelihood + variant.log_prior - reference.log_likelihood
            best[place[variant.key]] = max(best[place[variant.key]], gain)
        return best

    def path_gain(self, measured: Measured, bare: Design) -> float:
        """Gain of path offsets on one world."""
        without = self._fit(self.base, bare, measured, self.coefficients)
        with_ = self._fit(self.base, self.design, measured, self.coefficients)
        return max(0.0, with_.log_likelihood - without.log_likelihood)

    def _fit(self, tables: Tables, design: Design, measured: Measured, start: Floats) -> QuickFit:
        fit: QuickFit = quick_fit(
            bumps_of(tables, measured, self.study.sigma),
            measured.left,
            tables.edges,
            design,
            start,
            self.log_scatter,
            max(self.tau, 1e-3),
            self.student,
        )
        return fit


STEEPNESS = 0.5
"""Slope by which a height becomes a distance where places x are recorded."""


def sight_edges(variant: Variant, measured: Measured, study: Study) -> Edges:
    """Edges of sight where stops above the highest of each path, plus a margin, are not seen."""
    assert variant.margin is not None
    limit = study.limit.copy()
    in_x = study.kind == PLACE
    for k in range(len(study.columns.paths)):
        mine = (study.columns.path_index == k) & ~measured.left & np.isnan(study.limit)
        for kind, sign in ((in_x, -1.0), (~in_x, 1.0)):
            rows = mine & kind
            if np.any(rows):
                height = variant.margin / (STEEPNESS if sign < 0 else 1.0)
                everyone = (study.columns.path_index == k) & kind & np.isnan(study.limit)
                limit[everyone] = sign * (np.max(sign * measured.observed[rows]) + height)
    nobody = np.zeros(len(limit), dtype=np.bool_)
    silent = variant.tables.speeds._replace(row=np.full(len(limit), -1, dtype=np.int64))
    place = bumps(
        variant.tables.record,
        variant.tables.bounds,
        variant.tables.last_left,
        np.nan_to_num(limit),
        study.sigma,
        nobody,
        LOG_MU,
        silent,
        measured.speeds,
    )
    return variant.tables.edges._replace(
        seen=place.mean,
        seen_sd=np.sqrt(place.variance),
        has_limit=np.isfinite(limit) & (study.columns.path_index >= 0),
    )


def bumps_of(tables: Tables, measured: Measured, sigma: Floats):  # type: ignore[no-untyped-def]
    """Bumps of one world under one set of tables."""
    return bumps(
        tables.record,
        tables.bounds,
        tables.last_left,
        measured.observed,
        sigma,
        measured.left,
        LOG_MU,
        tables.speeds,
        measured.speeds,
    )


def _judge(
    candidates: Sequence[Definition],
    real: Floats,
    null: Floats,
    real_path: float,
    null_path: Floats,
) -> Screening:
    n_worlds = len(null)
    surprise = np.column_stack([_surprise(null[:, k], null[:, k]) for k in range(len(real))])
    largest = surprise.max(axis=1) if len(real) else np.zeros(n_worlds)
    result = []
    for k, entry in enumerate(candidates):
        s = float(_surprise(null[:, k], real[k : k + 1])[0])
        family = (1.0 + float(np.sum(largest >= s))) / (n_worlds + 1.0)
        chance = float(np.quantile(null[:, k], 0.95))
        mean = float(np.mean(null[:, k]))
        result.append(Screened(entry, float(real[k]), float(np.exp(-s)), family, chance, mean))
    result.sort(key=lambda c: (c.p_single, -c.gain))
    return Screening(
        candidates=tuple(result),
        path_gain=real_path,
        path_p=float(np.exp(-_surprise(null_path, np.array([real_path]))[0])),
        critical_gain=_critical_gain(largest),
        n_worlds=n_worlds,
    )


def _critical_gain(largest: Floats) -> float:
    """Gain of an effect with one parameter that 5 % of made worlds exceed with some candidate."""
    surprise = float(np.quantile(largest, 0.95))
    return 0.5 * float(stats.chi2.isf(np.exp(-surprise), 1))


def _surprise(null: Floats, gains: Floats) -> Floats:
    """-log p of gains: none in many made worlds, else gamma with the moments of the others.

    No gain is taken as more surprising than that of one free parameter, whose double is χ² with
    one degree of freedom: a short tail must not be drawn out from a few small gains.
    """
    positive = null[null > 1e-6]
    share = (1.0 + len(positive)) / (1.0 + len(null))
    tail = stats.chi2.logsf(2.0 * np.maximum(gains, 0.0), 1)
    if len(positive) >= MIN_POSITIVE:
        mean, variance = float(np.mean(positive)), float(np.var(positive))
        gamma = stats.gamma.logsf(gains, mean**2 / variance, scale=variance / mean)
        tail = np.maximum(tail, gamma)
    return np.where(gains > 1e-6, -(np.log(share) + tail), 0.0)


MIN_POSITIVE = 15
