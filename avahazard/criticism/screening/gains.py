"""What candidates, their pairs, groupings and limits gain on a dataset, by quick fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc, log_ndtr, stdtr

from avahazard.arrays import Floats
from avahazard.criticism.screening.candidates import Alternative, HeldAlternatives
from avahazard.criticism.screening.laplace_fit import Design, Edges, LaplaceFit, laplace_fit
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords
from avahazard.criticism.screening.record_moments import (
    NOTHING,
    RecordMoments,
    detection_edges,
    moments_of,
)
from avahazard.criticism.screening.tables import Tables
from avahazard.inference.model.friction_scatter import DEGREES, STUDENT_PULL
from avahazard.inference.model.observations import Observations
from avahazard.workers import ordered_map

Reference = tuple[RecordMoments, LaplaceFit]
"""What the records of one dataset say of friction, and the fit of the model itself to them."""

Indices = NDArray[np.int64]

MOST = 30
"""Effects that are paired: those of most gain alone where there are more."""
FIRST_SPREADS = (0.03, 0.1)
"""Spreads of groups that are tried as a start besides that of the records: from one alone the fit
to a simulated dataset falls short, and chance would look less than it is."""
MOST_FITS = 8
CONVERGED = 0.01
"""Nats by which a fit that begins where another ended may be likelier and count as the same."""


class Paired(NamedTuple):
    """Two effects by their place among the candidates, and how surprising they are together."""

    first: int
    second: int
    surprise: float


class EffectColumns(NamedTuple):
    """Columns `[n_events, n_columns]` of effects on friction, with the precision of their priors.

    `of` `[n_columns]` is the candidate whose column it is.
    """

    x: Floats
    precision: Floats
    of: Indices


@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """What every candidate gains on a dataset; groups may differ, from spreads `tau` on."""

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
    asks_detection: bool

    def of_candidates(
        self,
        datasets: Sequence[BootstrapRecords],
        references: Sequence[Reference],
        progress: Callable[[float], None] = lambda _share: None,
    ) -> Floats:
        """Gain of every candidate `[n_worlds, n_candidates]`, over the `reference` of each dataset.

        All datasets are gone through with one alternative before the next, whose tables may need
        the room.
        """
        best = np.zeros((len(datasets), len(self.keys)))
        place = {key: k for k, key in enumerate(self.keys)}
        for done, alternatives in enumerate(self.alternatives):
            gains = ordered_map(partial(self._largest, alternatives), datasets, references)
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
        """The largest gain of these on one dataset."""
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
            edges = detection_edges(
                alternative.tables, alternative.margin, measured, self.observations
            )
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
        """What limits at the highest stops of one dataset gain at the fit of the model itself."""
        moments, fit = reference
        known = self.base.edges
        edges = detection_edges(self.base, 0.0, measured, self.observations)
        return limit_by_chance(edges, known, self.design, fit, moments.variance, self.student)

    def of_pair(self, measured: BootstrapRecords, reference: Reference) -> Paired | None:
        """The pair of effects on friction that gains most over either alone, on one dataset."""
        moments, fit = reference
        return most_surprising_pair(
            moments, measured.left, self.design, fit, self.columns, self.student
        )

    def of_grouping(self, g: int, measured: BootstrapRecords, without: Design) -> float:
        """Gain of the offsets of one grouping on one dataset, over the design without them."""
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

        Where few stops are detected one alone falls short, and whatever is added would seem to
        gain.
        """
        left, edges = measured.left, self.base.edges
        coefficients, log_scatter = self.coefficients, self.log_scatter
        likeliest = None
        before = -np.inf
        for _ in range(MOST_FITS):
            fit: LaplaceFit = laplace_fit(
                moments, left, edges, design, coefficients, log_scatter, tau, self.student
            )
            if likeliest is None or fit.log_likelihood > likeliest.log_likelihood + CONVERGED:
                likeliest = fit
            if abs(fit.log_likelihood - before) < CONVERGED:
                break
            before = fit.log_likelihood
            coefficients, log_scatter, tau = fit.coefficients, fit.log_scatter, fit.tau
        assert likeliest is not None
        return likeliest


def limit_by_chance(
    edges: Edges, known: Edges, design: Design, fit: LaplaceFit, variance: Floats, student: bool
) -> float:
    """Gain (nats) of `edges` of detection over those `known`, at the model's own fit to a dataset.

    Nothing is fitted anew, so it is mostly chance. A limit just above the highest stop of a path
    makes every record there likelier, by about one nat a path where nothing is hidden, and that
    varies as an exponential does. Where stops are missing the gain is in what follows: law and
    scatter move.

    `variance` `[n_events]` is that of log friction from the records. Groups' offsets count with
    their spread.
    """
    located = design.constant + design.x @ fit.coefficients
    blur = np.maximum(edges.detected_sd**2, variance)
    tau2 = fit.tau**2
    shared = (design.places >= 0).T @ tau2 + design.alone.T @ tau2
    own = (np.exp(fit.log_scatter) * design.multiplier) ** 2
    z = (edges.detected - located) / np.sqrt(own + shared + blur + design.extra)
    log_detected = np.log(stdtr(float(DEGREES), z)) if student else log_ndtr(z)
    return float(-np.sum(log_detected[edges.has_limit & ~known.has_limit]))


def effect_columns(
    base: Tables, design: Design, alternatives: Sequence[Alternative], place: Mapping[str, int]
) -> EffectColumns:
    """The columns that candidates on friction add to the design of the model."""
    width = design.x.shape[1]
    x, precision, of = [design.x[:, :0]], [np.empty(0)], [np.empty(0, dtype=np.int64)]
    for a in alternatives:
        if a.tables is base and not a.other_law and a.design.x.shape[1] > width:
            x.append(a.design.x[:, width:])
            precision.append(a.design.prior_precision[width:])
            of.append(np.full(x[-1].shape[1], place[a.key], dtype=np.int64))
    return EffectColumns(np.hstack(x), np.concatenate(precision), np.concatenate(of))


def most_surprising_pair(
    moments: RecordMoments,
    left: NDArray[np.bool_],
    design: Design,
    fit: LaplaceFit,
    columns: EffectColumns,
    student: bool,
) -> Paired | None:
    """The pair that gains most over the better of its two; None where there are no two.

    Where two columns go together and their effects are opposed, each alone is near nothing. All
    pairs are looked through on one linear model of the records' moments, offsets of groups granted.
    The surprise is -log of χ²'s tail at twice that gain, with the freedom of both effects.
    """
    if len(np.unique(columns.of)) < 2:
        return None
    score, bend = _beside_the_model(moments, left, design, fit, columns, student)
    effects = np.unique(columns.of)
    mine = {int(k): np.flatnonzero(columns.of == k) for k in effects}
    alone = {k: _gain(score, bend, at) for k, at in mine.items()}
    kept = sorted(alone, key=lambda k: -alone[k])[:MOST]
    best = Paired(-1, -1, -1.0)
    for a, b in combinations(sorted(kept), 2):
        both = np.concatenate([mine[a], mine[b]])
        gain = _gain(score, bend, both) - max(alone[a], alone[b])
        tail = float(gammaincc(0.5 * len(both), max(gain, 0.0)))
        surprise = -float(np.log(max(tail, 1e-300)))
        if surprise > best.surprise:
            best = Paired(a, b, surprise)
    return best


def _gain(score: Floats, bend: Floats, at: Indices) -> float:
    """Rise of the log likelihood (nats) with the columns `at`."""
    own = score[at]
    return 0.5 * float(own @ np.linalg.solve(bend[np.ix_(at, at)], own))


def _beside_the_model(
    moments: RecordMoments,
    left: NDArray[np.bool_],
    design: Design,
    fit: LaplaceFit,
    columns: EffectColumns,
    student: bool,
) -> tuple[Floats, Floats]:
    """Score `[n_columns]` and curvature of the effects' columns, law and offsets fitted beside.

    Offsets of the largest grouping share no event, so that theirs is a diagonal.
    """
    known = ~(left & (moments.variance == 0.0))
    own = (np.exp(fit.log_scatter) * design.multiplier) ** 2
    own = own + np.sum(design.alone * fit.tau[:, None] ** 2, axis=0)
    variance = own + moments.variance + design.extra
    away = np.where(known, moments.mean - design.constant - design.x @ fit.coefficients, 0.0)
    weight = np.where(known, 1.0 / variance, 0.0)
    if student:
        weight *= STUDENT_PULL / (1.0 + 0.25 * away**2 / variance)
    x, precision = [design.x, columns.x], [design.prior_precision + 1e-9, columns.precision]
    centre = np.concatenate([design.prior_mean - fit.coefficients, np.zeros(len(columns.of))])
    sizes = np.bincount(design.of, minlength=max(len(fit.tau), 1))
    largest = int(np.argmax(sizes))
    for g in range(len(fit.tau)):
        if g != largest:
            names = np.flatnonzero(design.of == g)
            x.insert(1, (design.places[g][:, None] == names).astype(np.float64))
            precision.insert(1, np.full(len(names), fit.tau[g] ** -2.0))
            middle = design.x.shape[1]
            centre = np.insert(centre, np.full(len(names), middle), 0.0)
    z = np.hstack(x)
    prior = np.concatenate(precision)
    bend = (z * weight[:, None]).T @ z + np.diag(prior)
    score = z.T @ (weight * away) + prior * centre
    if len(fit.tau) and sizes[largest]:
        place = design.places[largest] - int(np.flatnonzero(design.of == largest)[0])
        inside = design.places[largest] >= 0
        by = np.zeros((sizes[largest], z.shape[1]))
        np.add.at(by, place[inside], (z * weight[:, None])[inside])
        total = np.zeros(sizes[largest])
        np.add.at(total, place[inside], weight[inside])
        pull = np.zeros(sizes[largest])
        np.add.at(pull, place[inside], (weight * away)[inside])
        total += fit.tau[largest] ** -2.0
        bend -= by.T @ (by / total[:, None])
        score -= by.T @ (pull / total)
    n = z.shape[1] - len(columns.of)
    beside = np.linalg.solve(bend[:n, :n], np.column_stack([bend[:n, n:], score[:n]]))
    left_over = score[n:] - bend[n:, :n] @ beside[:, -1]
    return left_over, bend[n:, n:] - bend[n:, :n] @ beside[:, :-1]
