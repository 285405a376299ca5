"""The gain of every candidate effect on one world, by quick fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.screening.alternatives import LOG_MU, Tables, Variant
from avahazard.criticism.screening.laplace_fit import Design, Edges, QuickFit, quick_fit
from avahazard.criticism.screening.parametric_bootstrap import Measured
from avahazard.criticism.screening.record_moments import bumps
from avahazard.inference.model.observations import PLACE, Study

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """What every candidate gains on a world; `tau` is the spread granted to path offsets."""

    base: Tables
    design: Design
    variants: list[Variant]
    keys: list[str]
    coefficients: Floats
    log_scatter: float
    tau: float
    student: bool
    study: Study

    def of_candidates(self, measured: Measured) -> Floats:
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

    def of_paths(self, measured: Measured, bare: Design) -> float:
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
