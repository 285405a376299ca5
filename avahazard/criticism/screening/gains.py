"""The gain of every candidate effect on one world, by quick fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.screening.alternatives import LOG_MU, Alternative, Tables
from avahazard.criticism.screening.laplace_fit import Design, Edges, LaplaceFit, laplace_fit
from avahazard.criticism.screening.masked_pairs import (
    EffectColumns,
    Paired,
    most_surprising_pair,
)
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords
from avahazard.criticism.screening.record_moments import record_moments
from avahazard.inference.model.observations import PLACE, Observations

Floats = NDArray[np.float64]


FIRST_SPREADS = (0.03, 0.1)
"""Spreads of groups that are tried as a start besides that of the records: from one alone the fit
to a made world falls short, and chance would look less than it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """What every candidate gains on a world; groups may differ, from spreads `tau` on."""

    base: Tables
    design: Design
    alternatives: list[Alternative]
    keys: list[str]
    coefficients: Floats
    log_scatter: float
    tau: Floats
    student: bool
    observations: Observations
    columns: EffectColumns

    def of_candidates(self, measured: BootstrapRecords) -> Floats:
        """Gain of every candidate `[n_candidates]` on one world."""
        reference = self._fit(self.base, self.design, measured, self.coefficients, self.tau)
        best = np.zeros(len(self.keys))
        place = {key: k for k, key in enumerate(self.keys)}
        summaries = {id(self.base): moments_of(self.base, measured)}
        for alternative in self.alternatives:
            summary = summaries.get(id(alternative.tables))
            if summary is None:
                summary = moments_of(alternative.tables, measured)
            width = alternative.design.x.shape[1]
            start = np.zeros(width)
            shared = min(width, len(reference.coefficients))
            if alternative.other_law:
                start = alternative.design.prior_mean.copy()
            else:
                start[:shared] = reference.coefficients[:shared]
            edges = alternative.tables.edges
            if alternative.margin is not None:
                edges = sight_edges(alternative, measured, self.observations)
            fit = laplace_fit(
                summary,
                measured.left,
                edges,
                alternative.design,
                start,
                reference.log_scatter,
                reference.tau,
                self.student,
            )
            gain = fit.log_likelihood + alternative.log_prior - reference.log_likelihood
            best[place[alternative.key]] = max(best[place[alternative.key]], gain)
        return best

    def of_pair(self, measured: BootstrapRecords) -> Paired | None:
        """The pair of effects on friction that gains most over either alone, on one world."""
        fit = self._fit(self.base, self.design, measured, self.coefficients, self.tau)
        moments = moments_of(self.base, measured)
        return most_surprising_pair(
            moments, measured.left, self.design, fit, self.columns, self.student
        )

    def of_grouping(self, g: int, measured: BootstrapRecords, without: Design) -> float:
        """Gain of the offsets of one grouping on one world, over the design without them."""
        bare = self._fit(self.base, without, measured, self.coefficients, np.delete(self.tau, g))
        likeliest = bare.log_likelihood
        for first in (self.tau[g], *FIRST_SPREADS):
            tau = self.tau.copy()
            tau[g] = first
            whole = self._fit(self.base, self.design, measured, self.coefficients, tau)
            likeliest = max(likeliest, whole.log_likelihood)
        return likeliest - bare.log_likelihood

    def _fit(
        self,
        tables: Tables,
        design: Design,
        measured: BootstrapRecords,
        start: Floats,
        tau: Floats,
    ) -> LaplaceFit:
        fit: LaplaceFit = laplace_fit(
            moments_of(tables, measured),
            measured.left,
            tables.edges,
            design,
            start,
            self.log_scatter,
            tau,
            self.student,
        )
        return fit


STEEPNESS = 0.5
"""Slope by which a height becomes a distance where places x are recorded."""


def sight_edges(
    alternative: Alternative, measured: BootstrapRecords, observations: Observations
) -> Edges:
    """Edges of sight where stops above the highest of each path, plus a margin, are not seen."""
    assert alternative.margin is not None
    limit = observations.limit.copy()
    in_x = observations.kind == PLACE
    for k in range(len(observations.columns.paths)):
        mine = (
            (observations.columns.path_index == k) & ~measured.left & np.isnan(observations.limit)
        )
        for kind, sign in ((in_x, -1.0), (~in_x, 1.0)):
            rows = mine & kind
            if np.any(rows):
                height = alternative.margin / (STEEPNESS if sign < 0 else 1.0)
                everyone = (
                    (observations.columns.path_index == k) & kind & np.isnan(observations.limit)
                )
                limit[everyone] = sign * (np.max(sign * measured.observed[rows]) + height)
    nobody = np.zeros(len(limit), dtype=np.bool_)
    silent = alternative.tables.speeds._replace(row=np.full(len(limit), -1, dtype=np.int64))
    place = record_moments(
        alternative.tables.record,
        alternative.tables.bounds,
        alternative.tables.last_left,
        alternative.tables.height,
        np.nan_to_num(limit),
        alternative.tables.sigma,
        nobody,
        LOG_MU,
        silent,
        measured.speeds,
    )
    return alternative.tables.edges._replace(
        seen=place.mean,
        seen_sd=np.sqrt(place.variance),
        has_limit=np.isfinite(limit) & (observations.columns.path_index >= 0),
    )


def moments_of(tables: Tables, measured: BootstrapRecords):  # type: ignore[no-untyped-def]
    """RecordMoments of one world under one set of tables."""
    return record_moments(
        tables.record,
        tables.bounds,
        tables.last_left,
        tables.height,
        measured.observed,
        tables.sigma,
        measured.left,
        LOG_MU,
        tables.speeds,
        measured.speeds,
    )
