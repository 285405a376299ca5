"""The gain of every candidate effect on many worlds, by quick fits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.alternatives import Alternative
from avahazard.criticism.screening.held_alternatives import HeldAlternatives
from avahazard.criticism.screening.laplace_fit import Design, LaplaceFit, laplace_fit
from avahazard.criticism.screening.limit_by_chance import limit_by_chance
from avahazard.criticism.screening.masked_pairs import (
    EffectColumns,
    Paired,
    most_surprising_pair,
)
from avahazard.criticism.screening.moments_of_worlds import moments_of, sight_edges
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords
from avahazard.criticism.screening.record_moments import NOTHING, RecordMoments
from avahazard.criticism.screening.tables import Tables
from avahazard.inference.model.observations import Observations
from avahazard.workers import ordered_map

Reference = tuple[RecordMoments, LaplaceFit]
"""What the records of one world say of friction, and the fit of the model itself to them."""

FIRST_SPREADS = (0.03, 0.1)
"""Spreads of groups that are tried as a start besides that of the records: from one alone the fit
to a made world falls short, and chance would look less than it is."""


MOST_FITS = 8
SETTLED = 0.01
"""Nats by which a fit that begins where another ended may be likelier and count as the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """What every candidate gains on a world; groups may differ, from spreads `tau` on."""

    base: Tables
    design: Design
    alternatives: HeldAlternatives
    keys: list[str]
    coefficients: Floats
    log_scatter: float
    tau: Floats
    student: bool
    observations: Observations
    columns: EffectColumns
    asks_sight: bool

    def of_candidates(
        self,
        worlds: Sequence[BootstrapRecords],
        references: Sequence[Reference],
        progress: Callable[[float], None] = lambda _share: None,
    ) -> Floats:
        """Gain of every candidate `[n_worlds, n_candidates]`, over the `reference` of each world.

        All worlds are gone through with one alternative before the next, whose tables may need the
        room.
        """
        best = np.zeros((len(worlds), len(self.keys)))
        place = {key: k for k, key in enumerate(self.keys)}
        for done, alternatives in enumerate(self.alternatives):
            gains = ordered_map(partial(self._largest, alternatives), worlds, references)
            k = place[alternatives[0].key]
            best[:, k] = np.maximum(best[:, k], list(gains))
            progress((done + 1) / len(self.alternatives))
        return best

    def reference(self, measured: BootstrapRecords) -> Reference:
        """What the records say, and the fit of the model itself."""
        moments = moments_of(self.base, measured)
        return moments, self._fit_to(moments, self.design, measured, self.tau)

    def _largest(
        self,
        alternatives: Sequence[Alternative],
        measured: BootstrapRecords,
        reference: Reference,
    ) -> float:
        """The largest gain of these on one world."""
        moments, fit = reference
        gains, tables = [], self.base
        for alternative in alternatives:
            if alternative.tables is not tables:
                alike = alternative.tables.record is tables.record
                tables = alternative.tables
                moments = moments_of(tables, measured, moments if alike else NOTHING)
            found = self._from_reference(alternative, moments, measured, fit)
            gains.append(found.log_likelihood + alternative.log_prior - fit.log_likelihood)
        return max(gains)

    def _from_reference(
        self,
        alternative: Alternative,
        moments: RecordMoments,
        measured: BootstrapRecords,
        reference: LaplaceFit,
    ) -> LaplaceFit:
        width = alternative.design.x.shape[1]
        start = np.zeros(width)
        shared = min(width, len(reference.coefficients))
        if alternative.other_law:
            start = alternative.design.prior_mean.copy()
        else:
            start[:shared] = reference.coefficients[:shared]
        edges = alternative.tables.edges
        if alternative.margin is not None:
            edges = sight_edges(alternative.tables, alternative.margin, measured, self.observations)
        found: LaplaceFit = laplace_fit(
            moments,
            measured.left,
            edges,
            alternative.design,
            start,
            reference.log_scatter,
            reference.tau,
            self.student,
        )
        return found

    def of_limit_by_chance(self, measured: BootstrapRecords, reference: Reference) -> float:
        """What limits at the highest stops of one world gain at the fit of the model itself."""
        moments, fit = reference
        known = self.base.edges
        edges = sight_edges(self.base, 0.0, measured, self.observations)
        return limit_by_chance(edges, known, self.design, fit, moments.variance, self.student)

    def of_pair(self, measured: BootstrapRecords, reference: Reference) -> Paired | None:
        """The pair of effects on friction that gains most over either alone, on one world."""
        moments, fit = reference
        return most_surprising_pair(
            moments, measured.left, self.design, fit, self.columns, self.student
        )

    def of_grouping(self, g: int, measured: BootstrapRecords, without: Design) -> float:
        """Gain of the offsets of one grouping on one world, over the design without them."""
        moments = moments_of(self.base, measured)
        bare = self._fit_to(moments, without, measured, np.delete(self.tau, g))
        likeliest = bare.log_likelihood
        for first in (self.tau[g], *FIRST_SPREADS):
            tau = self.tau.copy()
            tau[g] = first
            whole = self._fit_to(moments, self.design, measured, tau)
            likeliest = max(likeliest, whole.log_likelihood)
        return likeliest - bare.log_likelihood

    def _fit_to(
        self, moments: RecordMoments, design: Design, measured: BootstrapRecords, tau: Floats
    ) -> LaplaceFit:
        """The likeliest of fits that each begin where the one before ended, until they stay there.

        Where few stops are seen one alone falls short, and whatever is added would seem to gain.
        """
        left, edges = measured.left, self.base.edges
        coefficients, log_scatter = self.coefficients, self.log_scatter
        likeliest = None
        before = -np.inf
        for _ in range(MOST_FITS):
            fit: LaplaceFit = laplace_fit(
                moments, left, edges, design, coefficients, log_scatter, tau, self.student
            )
            if likeliest is None or fit.log_likelihood > likeliest.log_likelihood + SETTLED:
                likeliest = fit
            if abs(fit.log_likelihood - before) < SETTLED:
                break
            before = fit.log_likelihood
            coefficients, log_scatter, tau = fit.coefficients, fit.log_scatter, fit.tau
        assert likeliest is not None
        return likeliest
