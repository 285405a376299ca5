"""Pairs of effects on friction that hide each other: what two gain together and neither alone.

Where two columns go together and their effects are opposed, each alone is near nothing. All pairs
are looked through on one linear model of the records' moments, offsets of groups granted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from avahazard.arrays import Floats
from avahazard.criticism.screening.alternatives import Alternative
from avahazard.criticism.screening.laplace_fit import Design, LaplaceFit
from avahazard.criticism.screening.record_moments import RecordMoments
from avahazard.criticism.screening.tables import Tables
from avahazard.inference.model.friction_scatter import STUDENT_PULL

Indices = NDArray[np.int64]

MOST = 30
"""Effects that are paired: those of most gain alone where there are more."""


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
