"""A fitted model as a linear one: what each record says of small changes, in standard errors.

Rows of events with unit errors, of which a change of the model is a column; what the model has
itself is projected out, and offsets of groups are random, so that a score is that of the marginal
likelihood (docs/theory/criticism.md, "The linear model of a fit").
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

from avahazard.arrays import Floats, Ints
from avahazard.criticism.scoring.speed_misfit import friction_given_record, stop_nodes
from avahazard.effects.effect import (
    Effect,
    FrictionEffect,
    GroupEffect,
    RecordErrorEffect,
    ScatterEffect,
    VolumeErrorEffect,
)
from avahazard.inference.fitting.mode import units
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.terms import event_terms
from avahazard.inference.likelihood.track_nodes import squared
from avahazard.inference.model.friction_model import DEGREES, STUDENT_INFORMATION, volume_share
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.observations import SpeedRecord
from avahazard.inference.model.specification import Specification
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import MU
from avahazard.physics.speed import speeds_along
from avahazard.physics.terrain import node_of

Normal = tuple[float, float]
"""Mean and variance of log friction."""
LOG_MU, NOTHING = np.log(MU), np.empty(0)
LEAST_VARIANCE, LEAST_BEND, LEAST_SHARE = 1e-8, 1e-6, 1e-6
MOST_VARIANCE = 1.0
"""Of the log friction that a record asks for: of a vaguer one, and of one beyond the profile."""
STEP = 1e-3
"""Step of an effect's parameter, in prior standard deviations. An effect shifts all friction as
well, which the law takes up: over a longer step that alone would bend the score."""
MOST_TIMES, FARTHEST = 10.0, 5.0
"""Of the median event's change, and of what is usually left over, the most that one can have."""
NO_SPEED = 1e5
"""Error of a square of speed (m²/s²) without information."""
NEAR = 0.02
"""Log friction over which F(μ) of an event with speeds is taken as straight."""


class Variances(NamedTuple):
    """Variance of log friction `[n_events]`: by the record's error, natural, by the volume's."""

    record: Floats
    scatter: Floats
    volume: Floats

    @property
    def total(self) -> Floats:
        """All together."""
        return np.asarray(self.record + self.scatter + self.volume)


class Moved(NamedTuple):
    """A model with an effect at some values of its parameters.

    Log likelihood of each event `[n_events]`, the log friction that each stop asks for, and squares
    of speed `[n_speeds]` along each track at the friction that its record asks of the base.
    """

    log_likelihood: Floats
    asked: Floats
    squares: Sequence[Floats]


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Rows of a model at its mode u.

    Of each event its stop and speeds, from `first` `[n_events + 1]` on; then one each of scatter,
    then one each of what exact scores have beyond these. `residual` `[n_rows]` is left over,
    `shift` its derivative by a shift of the event's log friction, `widen` that of a row of
    scatter by the log of the event's standard deviation. `score` `[n_events]` is that of a
    shift, `log_friction` `[n_events]` what stop and speeds ask for, `roots` whiten
    them where there are speeds.
    """

    posterior: Posterior
    u: Floats
    offsets: Floats | None
    variances: Variances
    gone: NDArray[np.bool_]
    score: Floats
    log_friction: Floats
    roots: dict[int, Floats]
    first: Ints
    residual: Floats
    shift: Floats
    widen: float

    @property
    def n_events(self) -> int:
        """Number of events."""
        return len(self.score)

    @property
    def of_scatter(self) -> slice:
        """The rows of scatter."""
        return slice(int(self.first[-1]), int(self.first[-1]) + self.n_events)

    def on_friction(self, columns: Floats) -> Floats:
        """Rows `[n_rows, n]` of columns `[n_events, n]` that are added to log friction."""
        rows = np.zeros((len(self.residual), columns.shape[1]))
        of_event = np.repeat(columns, np.diff(self.first), axis=0)
        rows[: self.first[-1]] = self.shift[:, None] * of_event
        return rows

    def on_scatter(self, columns: Floats) -> Floats:
        """Rows `[n_rows, n]` of columns `[n_events, n]` added to the log of standard deviations."""
        rows = np.zeros((len(self.residual), columns.shape[1]))
        rows[self.of_scatter] = np.where(self.gone[:, None], 0.0, self.widen * columns)
        return rows

    def on_natural_scatter(self, columns: Floats) -> Floats:
        """The same of columns that are added to the log of natural scatter alone."""
        share = self.variances.scatter / self.variances.total
        return self.on_scatter(share[:, None] * columns)

    def of_effect(self, effect: Effect, values: Floats, of_first: bool = False) -> Floats:
        """Rows `[n_rows, n_parameters]`: changes by each parameter of an effect, or the first."""
        if isinstance(effect, FrictionEffect):
            return self.on_friction(effect.design(self.posterior.observations.columns))
        if isinstance(effect, ScatterEffect):
            return self.on_natural_scatter(effect.design(self.posterior.observations.columns))
        parameters = effect.parameters[: 1 if of_first else None]
        room = [min(p.prior_sd, p.high - p.low) for p in parameters]
        steps = STEP * np.array(room)
        high = np.array([p.high for p in parameters])
        steps = np.where(values[: len(steps)] + 2.0 * steps <= high, steps, -steps)
        # Those that act on one path each are moved together, one of every path.
        paths = effect.paths[: len(steps)]
        turns = [paths[:k].count(p) for k, p in enumerate(paths)] or range(len(steps))
        turn = np.array(turns)
        # Not from the neutral value itself: there blocks run on other cells.
        here = values.copy()
        here[: len(steps)] += np.where(turn == 0, steps, 0.0)
        beside = self.beside(effect)
        before = self.moved(beside, effect, here)
        columns = np.empty((len(self.residual), len(steps)))
        for k in np.unique(turn):
            moved = np.flatnonzero(turn == k)
            there, step = here.copy(), float(steps[moved[0]])
            there[moved] += step
            after = self.moved(beside, effect, there)
            if isinstance(effect, VolumeErrorEffect | RecordErrorEffect):
                known = self.variances
                part = known.record if isinstance(effect, RecordErrorEffect) else known.volume
                rows = self.on_scatter((part / known.total)[:, None])[:, 0]
            else:
                rows = self.by_motion(before, after) / step
            rows = self.bounded(self.with_rest(rows, before, after, step))
            columns[:, moved] = rows[:, None]
        if paths:
            data = self.posterior.observations.columns
            index = [data.paths.index(p) if p in data.paths else -2 for p in paths]
            columns *= data.path_index[self._event, None] == np.array(index)
        return columns

    @property
    def _event(self) -> Ints:
        """The event of each row `[n_rows]`."""
        each = np.arange(self.n_events)
        return np.concatenate([np.repeat(each, np.diff(self.first)), each, each])

    def bounded(self, rows: Floats) -> Floats:
        """Rows `[n_rows]` in which an event counts for at most `MOST_TIMES` the median one."""
        size = np.sqrt(np.bincount(self._event, rows**2))
        share = np.ones(self.n_events)
        for alike in (np.diff(self.first) == 1, np.diff(self.first) > 1):
            if np.any(some := alike & (size > 0.0)):
                share[some] = np.minimum(1.0, MOST_TIMES * np.median(size[some]) / size[some])
        return np.asarray(rows * share[self._event])

    def beside(
        self, effect: Effect | None = None, specification: Specification | None = None
    ) -> Posterior:
        """The posterior with an effect, or with another specification."""
        base, effects = self.posterior, self.posterior.effects
        if effect is not None and effect.key not in base.layout.places:
            effects = (*effects, effect)
        return Posterior(base.observations, specification or base.specification, effects)

    def moved(
        self, beside: Posterior, effect: Effect | None = None, values: Floats = NOTHING
    ) -> Moved:
        """The model `beside` with an effect at these values, all else as it is."""
        u = by_name(self.posterior.layout, self.u, beside.layout)
        if effect is not None:
            u = put(u, beside.layout, effect.key, values)
        table = beside.nodes.near_records(u) if self.roots else None
        pinned = beside.pinned(u)
        stops = pinned.nodes_at(u) if table is None else stop_nodes(beside, table)
        asked, _ = _moments(stops, beside.layout.log_scatter)
        likelihood = pinned.event_log_likelihood(u, self.offsets)
        return Moved(likelihood, asked, self._squares(beside, u))

    def _squares(self, beside: Posterior, u: Floats) -> list[Floats]:
        """Squares of speed along each track as in `Moved`, with the block of `beside` at u."""
        records, values = beside.observations, beside.layout.effect_values(u)
        path, cells, squares = records.columns.path_index, dict[int, Cells](), []
        for track in records.speeds:
            k = int(path[track.event])
            site = records.sites[k]
            if k not in cells:
                cells[k] = site.cells(beside.resistance(site, values))
            start = node_of(cells[k].x, float(site.release_x[records.release[track.event]]))
            friction = np.exp(self.log_friction[track.event : track.event + 1])
            squares.append(speeds_along(cells[k], start, friction, track.x)[0] ** 2)
        return squares

    def by_motion(self, before: Moved, after: Moved) -> Floats:
        """Rows `[n_rows]` of the change between two models whose records are expected otherwise."""
        gain = after.log_likelihood - before.log_likelihood
        change = np.where(self.gone, 0.0, before.asked - after.asked)
        told = self.gone & (np.abs(self.score) > LEAST_BEND)
        change[told] = gain[told] / self.score[told]
        rows = self.on_friction(change[:, None])[:, 0]
        both = before.squares, after.squares
        for track, slow, fast in zip(self.posterior.observations.speeds, *both, strict=True):
            i = track.event
            shift = 0.0 if self.gone[i] else change[i]
            rows[self.first[i] : self.first[i + 1]] = self.roots[i] @ np.append(shift, fast - slow)
        return rows

    def with_rest(self, rows: Floats, before: Moved, after: Moved, step: float = 1.0) -> Floats:
        """The rows with what the exact scores have beyond them; of events with speeds nothing."""
        exact = (after.log_likelihood - before.log_likelihood) / step
        given = rows * self.residual
        selected = (
            np.add.reduceat(given[: self.first[-1]], self.first[:-1]) + given[self.of_scatter]
        )
        alone = ~self.gone & (np.diff(self.first) == 1)
        rows[self.of_scatter.stop :] = np.where(alone, exact - selected, 0.0)
        return rows

    @cached_property
    def own(self) -> tuple[Floats, Floats]:
        """Changes of the model itself `[n_rows, n_own]`, and the precision of their priors."""
        posterior, u, layout = self.posterior, self.u, self.posterior.layout
        columns, sd = [], []
        small = 1e-4 * units(posterior)
        for k in range(len(layout.law.coordinates)):
            step = np.zeros(len(u))
            step[k] = small[k]
            change = _mean_log_friction(posterior, u + step) - _mean_log_friction(
                posterior, u - step
            )
            columns.append(self.on_friction(change[:, None] / (2.0 * small[k])))
            sd.append(layout.slots[k].sd)
        columns.append(self.on_natural_scatter(np.ones((self.n_events, 1))))
        sd.append(layout.slots[layout.scatter].sd)
        if layout.scatter_slope is not None:
            share = volume_share(np.exp(posterior.volumes(u).mean), layout.reference_volume)
            columns.append(self.on_natural_scatter(-share[:, None]))
            sd.append(layout.slots[layout.scatter_slope].sd)
        values = layout.effect_values(u)
        for effect in posterior.effects:
            if not isinstance(effect, GroupEffect):
                columns.append(self.of_effect(effect, values[effect.key]))
                sd += [p.prior_sd for p in effect.parameters]
        return np.column_stack(columns), np.array(sd) ** -2.0

    @cached_property
    def members(self) -> tuple[csr_matrix, Floats]:
        """Rows `[n_rows, n_offsets]` of the offsets of groups, and the spread of each."""
        plan, n_rows = self.posterior.plan, len(self.residual)
        if not plan:
            return csr_matrix(np.empty((n_rows, 0))), np.empty(0)
        event = np.repeat(np.arange(self.n_events), np.diff(self.first))
        index = plan.index[:, event]
        grouping, rows = np.nonzero(index >= 0)
        entries = self.shift[rows], (rows, index[grouping, rows])
        tau = self.posterior.layout.spread_values(self.u)[plan.of]
        return csr_matrix(entries, shape=(n_rows, len(plan.of))), np.maximum(tau, 1e-6)

    def projected(self, columns: Floats, but_last: int = 0) -> Floats:
        """P C `[n_rows, n]`: what of columns nothing of the model can do, weighed by V⁻¹.

        V is the covariance of the rows, with the offsets of groups. The last changes of the model
        itself, as many as `but_last`, take no part.
        """
        own, precision = self.own
        n = len(precision) - but_last
        own = own[:, :n]
        both = np.column_stack([own, columns])
        members, tau = self.members
        if len(tau):
            inner = csc_matrix(members.T @ members + diags(tau**-2.0))
            both -= members @ splu(inner).solve(np.ascontiguousarray(members.T @ both))
        bend = own.T @ both[:, :n] + np.diag(precision[:n] + 1e-9)
        taken = np.linalg.solve(bend, both[:, :n].T @ columns)
        return np.asarray(both[:, n:] - both[:, :n] @ taken)

    def by_chance(self, n: int, rng: np.random.Generator) -> Floats:
        """Rows `[n_rows, n]` as they are where nothing is missing."""
        rows = rng.standard_normal((len(self.residual), n))
        rows[self.of_scatter] = (rows[self.first[:-1]] ** 2 - 1.0) / np.sqrt(2.0)
        members, tau = self.members
        return np.asarray(rows + members @ (tau[:, None] * rng.standard_normal((len(tau), n))))


def by_name(before: Layout, u: Floats, layout: Layout) -> Floats:
    """Coordinates u of the layout `before` in another one; slots that are new stand at neutral."""
    known = dict(zip((slot.name for slot in before.slots), u, strict=True))
    rest = [s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots]
    return np.array([known.get(s.name, at) for s, at in zip(layout.slots, rest, strict=True)])


def put(u: Floats, layout: Layout, key: str, values: Floats) -> Floats:
    """Coordinates u `[n_slots]` with these values of the parameters of one effect."""
    u, place = u.copy(), layout.places[key]
    u[place] = values / np.array([slot.scale for slot in layout.slots[place]])
    return u


def linear_model(posterior: Posterior, u: Floats) -> LinearModel:
    """The rows of a model at its mode u."""
    observations, layout = posterior.observations, posterior.layout
    offsets, nodes = posterior.mode_offsets(u), posterior.nodes_at(u)
    location, scatter, weight = of_friction = posterior.friction_at(u, offsets)
    student = posterior.friction.student
    terms = event_terms(nodes, location, scatter, weight, student)
    mean = np.sum(weight * location, axis=1)
    unit = np.ones(len(mean)) if layout.log_scatter else np.maximum(mean, 1e-3)
    log_mean = mean if layout.log_scatter else np.log(unit)
    asked, record = _moments(nodes, layout.log_scatter)
    variances = Variances(
        record,
        np.sum(weight * scatter**2, axis=1) / unit**2,
        np.sum(weight * (location - mean[:, None]) ** 2, axis=1) / unit**2,
    )
    gone = nodes.is_probability
    root = np.sqrt(((DEGREES + 1.0) / (DEGREES + 3.0) if student else 1.0) / variances.total)
    root = np.where(gone, np.sqrt(np.maximum(-terms.curvature, LEAST_BEND)) * unit, root)
    score = np.sum(terms.by_location, axis=1) * unit
    widen = float(np.sqrt(STUDENT_INFORMATION if student else 2.0))
    share = np.maximum(variances.scatter / variances.total, LEAST_SHARE)
    if layout.kinds is not None and not gone.all():
        # A record that indicates its kind has more information than one with the common scatter.
        stopped = ~gone
        root[stopped] *= np.sqrt(np.mean((score / root)[stopped] ** 2))
        widen = float(np.sqrt(np.mean((np.sum(terms.by_scatter, axis=1) / share)[stopped] ** 2)))
    apart = np.where(gone, 0.0, np.sum(terms.by_scatter, axis=1) / (share * widen))
    rows = [(score[i : i + 1] / root[i], root[i : i + 1]) for i in range(len(mean))]
    roots, log_friction = {}, np.where(gone, log_mean, asked)
    if observations.speeds:
        table = posterior.nodes.predicted_at(u)
        stops = _moments(stop_nodes(posterior, table), layout.log_scatter)
        sigma = layout.track_sigma(u)
        for track, block in zip(observations.speeds, table.speeds, strict=True):
            i = track.event
            places, chance = friction_given_record(posterior, nodes, i, of_friction)
            log_friction[i] = at = float(chance @ np.log(np.maximum(places, MU[0])))
            by_model = log_mean[i], variances.scatter[i] + variances.volume[i]
            stop = (0.0, MOST_VARIANCE) if gone[i] else (stops[0][i] - log_mean[i], stops[1][i])
            roots[i], left, slope = _track(track, block.speed**2, sigma, at, by_model, stop)
            rows[i] = left, slope
    first = np.concatenate([[0], np.cumsum([len(r) for r, _ in rows])])
    residual = winsorised(np.concatenate([r for r, _ in rows]), first)
    return LinearModel(
        posterior=posterior,
        u=u,
        offsets=offsets,
        variances=variances,
        gone=gone,
        score=score,
        log_friction=log_friction,
        roots=roots,
        first=first,
        residual=np.concatenate([residual, apart, np.ones(len(mean))]),
        shift=np.concatenate([r for _, r in rows]),
        widen=widen,
    )


def winsorised(residual: Floats, first: Ints) -> Floats:
    """What is left over of stops and speeds, of no event over `FARTHEST` times what is usual."""
    n_rows = np.diff(first)
    size = np.sqrt(np.add.reduceat(residual**2, first[:-1]) / n_rows)
    usual = np.ones(len(size))
    for alike in (n_rows == 1, n_rows > 1):
        if alike.any():
            usual[alike] = max(1.0, float(np.median(size[alike])))
    share = np.minimum(1.0, FARTHEST * usual / np.maximum(size, 1e-300))
    return np.asarray(residual * np.repeat(share, n_rows))


def _moments(nodes: Nodes, in_log: bool) -> tuple[Floats, Floats]:
    """Log friction that each record asks for `[n_events]`, and its variance by the record's error.

    Of the likelihood over friction alone; of an event beyond the profile they mean nothing.
    """
    place = nodes.place if in_log else np.log(np.maximum(nodes.place, MU[0]))
    weight = np.where(nodes.is_probability[:, None], 0.0, nodes.weight)
    total = np.maximum(np.sum(weight, axis=1), 1e-300)
    mean = np.sum(place * weight, axis=1) / total
    square = np.sum(weight * (place - mean[:, None]) ** 2, axis=1) / total
    variance = np.clip(square, LEAST_VARIANCE, MOST_VARIANCE)
    return mean, np.where(nodes.is_probability, LEAST_VARIANCE, variance)


def _track(
    track: SpeedRecord, squares: Floats, sigma: float, at: float, by_model: Normal, stop: Normal
) -> tuple[Floats, Floats, Floats]:
    """What whitens a stop with speeds, their rows, and derivatives by a shift of log friction.

    `squares` `[n_friction, n_speeds]` are expected, about log friction `at`; the model expects
    `by_model`, and the `stop` is away from that mean.
    """
    (mean, natural), (away, error) = by_model, stop
    square, of_speed = squared(track.speed, track.sigma)
    # From the side on which the block comes to all places.
    behind, here = np.array([np.interp([at - NEAR, at], LOG_MU, column) for column in squares.T]).T
    slope = (here - behind) / NEAR
    expected = here + slope * (mean - at)
    shift = np.append(1.0, slope)
    covariance = natural * np.outer(shift, shift)
    covariance[0, 0] += error
    # A place that the block only just reaches has no linear response.
    first, last = np.searchsorted(LOG_MU, [at - NEAR, at + 2.0 * NEAR])
    arrives = np.all(squares[max(first - 1, 0) : last + 1] > 0.0, axis=0)
    of_speed = np.where(arrives, of_speed, NO_SPEED)
    covariance[1:, 1:] += sigma**2 * track.spread + np.diag(of_speed**2)
    root = np.linalg.inv(np.linalg.cholesky(covariance))
    return root, root @ np.append(away, square - expected), root @ shift


def _mean_log_friction(posterior: Posterior, u: Floats) -> Floats:
    location, _ = posterior.location_and_scatter(u)
    if not posterior.layout.log_scatter:
        location = np.log(np.maximum(location, 1e-3))
    return np.asarray(np.sum(location * posterior.weight(u), axis=1))
