"""The friction of avalanches by a model: its law, effects on friction, groups, and scatter.

Friction scatters about the law normally, or as Student's t with 4 degrees of freedom. With location
m and scatter σ, z = (ν - m) / σ, where ν is log μ, or μ itself where friction is normal. Student's
tails let a few records be grossly wrong. Densities are in z: those in ν are 1/σ of them. A
derivative in m is -1/σ of that in z, one in log σ is -z times it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtr

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import NO_EVENTS, EventColumns
from avahazard.effects.effect import Effect, FrictionEffect, GroupEffect, ScatterEffect, of_kind
from avahazard.inference.model.laws import bounded
from avahazard.inference.model.layout import Arms, Layout, build_layout
from avahazard.inference.model.specification import Specification
from avahazard.kernels import kernel

DEGREES = 4
"""Degrees of freedom of Student's t; the closed forms below hold for these alone."""
NORMAL_PEAK = 1.0 / math.sqrt(2.0 * math.pi)
STUDENT_PEAK, STUDENT_PULL = 0.375, 1.25
HALF_LOG_2PI = 0.5 * math.log(2.0 * math.pi)
LOG_STUDENT_PEAK = math.log(STUDENT_PEAK)
STUDENT_INFORMATION = 8.0 / 7.0
"""Fisher information in log σ, 2 DEGREES / (DEGREES + 3); that of the normal is 2."""
ROOT_2 = math.sqrt(2.0)


@kernel(forceinline=True)
def normal_density(z: float) -> float:
    """φ(z); its derivative is -z φ."""
    return NORMAL_PEAK * math.exp(-0.5 * z * z)


@kernel(forceinline=True)
def normal_below(z: float) -> float:
    """Φ(z)."""
    return 0.5 * math.erfc(-z / ROOT_2)


@kernel(forceinline=True)
def student_density(z: float) -> tuple[float, float, float]:
    """t(z) = STUDENT_PEAK shape^(5/2), -t'(z)/t(z) = STUDENT_PULL z shape, and t''(z)/t(z)."""
    shape = 1.0 / (1.0 + 0.25 * (z * z))
    pull = STUDENT_PULL * z * shape
    density = STUDENT_PEAK * shape * shape * math.sqrt(shape)
    return density, pull, 1.4 * pull * pull - STUDENT_PULL * shape


@kernel(forceinline=True)
def student_below(z: float) -> float:
    """The chance under z, good far into the lower tail."""
    root = math.sqrt(1.0 + 0.25 * z * z)
    # z / root + 2, of which nothing is left where both are large.
    gap = 4.0 / ((2.0 * root - z) * root) if z < 0.0 else 2.0 + z / root
    return gap * gap * (4.0 - z / root) / 32.0


def below(z: Floats, student: bool) -> Floats:
    """The chance under z, of any shape."""
    return np.asarray(stdtr(float(DEGREES), z) if student else ndtr(z))


def log_density(z: Floats, student: bool) -> Floats:
    """Log density at z, of any shape."""
    if student:
        return np.asarray(LOG_STUDENT_PEAK - 2.5 * np.log1p(0.25 * z**2))
    return np.asarray(-0.5 * z**2 - HALF_LOG_2PI)


def draws(rng: np.random.Generator, size: int | tuple[int, ...], student: bool) -> Floats:
    """Draws of z."""
    return rng.standard_t(DEGREES, size=size) if student else rng.standard_normal(size)


def widening(rng: np.random.Generator, n: int) -> Floats:
    """Factors `[n]` that turn normal draws of z into Student's, whose variance is drawn."""
    return np.asarray(np.sqrt(DEGREES / rng.chisquare(DEGREES, n)))


def volume_share(volume: Floats, reference: float) -> Floats:
    """What log σ is linear in where scatter goes with volume: V over the reference, at most 1.

    Nine events in ten stay under the reference volume. Beyond it a few large events would decide
    the slope, and a straight line in V would soon let σ explode or vanish.
    """
    return np.minimum(volume / reference, 1.0)


def shifted(location: Floats, shift: Floats | float, in_log: bool) -> Floats:
    """The location with `shift` added to log friction; `in_log`: it is one of log μ."""
    return np.asarray(location + shift if in_log else location * np.exp(shift))


def friction(location: Floats, deviation: Floats, in_log: bool) -> Floats:
    """μ that lies `deviation` = σ z from its location."""
    return np.asarray(np.exp(location + deviation) if in_log else location + deviation)


@dataclass(frozen=True, eq=False)
class OffsetPlan:
    """Groupings by the effects `keys`, crossed or nested as they come, and their offsets.

    `index` `[n_groupings, n_events]` is the place of an event's offset in the row of all, -1 for
    none; `alone` `[n_groupings, n_events]`: it has one of its own, which adds to its scatter.
    `of` `[n_offsets]` is the grouping of each, `names` and `told` `[n_offsets]` what it is called
    in the store and by people. `persistent` `[n_groupings]`: what is to come has the same groups.
    """

    keys: tuple[str, ...]
    names: tuple[str, ...]
    told: tuple[str, ...]
    of: Ints
    index: Ints
    alone: NDArray[np.bool_]
    persistent: tuple[bool, ...]

    def __bool__(self) -> bool:
        return len(self.keys) > 0

    @cached_property
    def rest(self) -> Ints:
        """Place of each offset `[n_offsets]` among those that are not of the largest grouping.

        -1 for those that are: given the others, they know nothing of each other.
        """
        counts = np.bincount(self.of, minlength=max(len(self.keys), 1))
        others = self.of != np.argmax(counts)
        return np.where(others, np.cumsum(others) - 1, -1)

    def shift(self, offsets: Floats) -> Floats:
        """Sum of the offsets `[n_offsets]` that each event has, `[n_events]`."""
        row = np.append(offsets, 0.0)
        return np.asarray(row[self.index].sum(axis=0), dtype=np.float64)


def offset_plan(effects: Sequence[Effect], columns: EventColumns) -> OffsetPlan:
    """The groupings of a model's effects on these events."""
    by_key = {e.key: e.groups(columns) for e in of_kind(effects, GroupEffect)}
    groups, shape = by_key.values(), (len(by_key), len(columns))
    sizes = [len(g.names) for g in groups]
    first = np.cumsum([0, *sizes])[:-1]
    index = [np.where(g.index >= 0, g.index + k, -1) for g, k in zip(groups, first, strict=True)]
    return OffsetPlan(
        keys=tuple(by_key),
        names=tuple(name for g in groups for name in g.names),
        told=tuple(f"{g.told}{name}" for g in groups for name in g.names),
        of=np.repeat(np.arange(len(sizes)), sizes),
        index=np.array(index, dtype=np.int64).reshape(shape),
        alone=np.array([g.alone & (g.index < 0) for g in groups], dtype=np.bool_).reshape(shape),
        persistent=tuple(not g.alone for g in groups),
    )


MOST_LOG_SCATTER, LEAST_LOG_SCATTER = 4.0, -12.0


class EventFriction(NamedTuple):
    """What friction takes of some events.

    `shifts`: the slots of each effect that shifts log friction, and what their coordinates are
    multiplied by, `[n_events, n_parameters]`; `widens`: the same of those on the log of the
    scatter. `plan`: the groups of the events.
    """

    shifts: list[tuple[slice, Floats]]
    widens: list[tuple[slice, Floats]]
    plan: OffsetPlan


class FrictionKinds(NamedTuple):
    """`[..., n_kinds]`: the share of each kind, and how far its log friction lies from the mean."""

    share: Floats
    shift: Floats

    def drawn(self, chance: Floats) -> Floats:
        """The shift of the kind that a uniform number draws, of any shape that fits."""
        second = chance < self.share[..., 1]
        return np.where(second, self.shift[..., 1], self.shift[..., 0])


@dataclass(frozen=True, slots=True, eq=False)
class FrictionModel:
    """Friction given the coordinates u `[..., n_slots]` of a model, for any events.

    Its law, `effects` on friction and scatter are in `layout`; `student`: the scatter is
    Student's t. Locations are of log μ, or of μ where friction is normal.
    """

    layout: Layout
    effects: tuple[Effect, ...]
    student: bool

    def of_events(self, columns: EventColumns) -> EventFriction:
        """What friction takes of events."""
        shifts = [self._design(e, columns) for e in of_kind(self.effects, FrictionEffect)]
        widens = [self._design(e, columns) for e in of_kind(self.effects, ScatterEffect)]
        return EventFriction(shifts, widens, offset_plan(self.effects, columns))

    def _design(
        self, effect: FrictionEffect | ScatterEffect, columns: EventColumns
    ) -> tuple[slice, Floats]:
        place = self.layout.places[effect.key]
        scales = np.array([slot.scale for slot in self.layout.slots[place]])
        return place, effect.design(columns) * scales

    @property
    def persistent(self) -> tuple[bool, ...]:
        """Of each grouping, whether what is to come has the same groups, as of paths."""
        return offset_plan(self.effects, NO_EVENTS).persistent

    def line_covariate(self, volume: Floats) -> Floats | None:
        """What log μ is a line in at volumes (m3), `[n_events, n_volumes]`; None for other laws."""
        law = self.layout.law
        is_line = law.form == "line" and len(law.coordinates) == 2
        return law.covariate(volume) if is_line else None

    def kinds(self, u: Floats) -> FrictionKinds | None:
        """The kinds of avalanche at coordinates u `[..., n_slots]`; None where all are of one."""
        place = self.layout.kinds
        if place is None:
            return None
        scales = np.array([slot.scale for slot in self.layout.slots[place]])
        share, shift = np.moveaxis(u[..., place] * scales, -1, 0)
        if not np.any(shift):
            return None
        shares = np.stack([1.0 - share, share], axis=-1)
        return FrictionKinds(shares, np.stack([-share * shift, (1.0 - share) * shift], axis=-1))

    def location_and_scatter(
        self,
        u: Floats,
        volume: Floats,
        events: EventFriction | None = None,
        covariate: Floats | None = None,
    ) -> tuple[Floats, Floats]:
        """Location m and scatter σ of friction, each `[..., n_events, n_volumes]`.

        At coordinates u `[..., n_slots]` and volumes (m3) `[n_events, n_volumes]`. What an event
        has for itself of a grouping is in its scatter. `events` None: by the law alone.
        `covariate` is `line_covariate` where it is known: its logarithms are most of the work.
        Where avalanches are of several kinds, this is the mean of these (`by_kind`).
        """
        if events is None:
            return self._located(u, volume, [], [], np.zeros(len(volume)), covariate)
        own = self.layout.spread_values(u) ** 2 @ events.plan.alone
        return self._located(u, volume, events.shifts, events.widens, own, covariate)

    def by_kind(self, u: Floats, location: Floats, scatter: Floats) -> tuple[Floats, Floats]:
        """The same of each kind, one after the other: `[..., n_events, n_kinds * n_volumes]`."""
        kinds = self.kinds(u)
        if kinds is None:
            return location, scatter
        shifts = np.moveaxis(kinds.shift, -1, 0)[..., None, None]
        each = [self.shifted(location, shift) for shift in shifts]
        return np.concatenate(each, axis=-1), np.concatenate([scatter] * len(each), axis=-1)

    def weights_by_kind(self, u: Floats, weight: Floats) -> Floats:
        """Weights of volumes `[n_events, n_volumes]` for the nodes of `by_kind`."""
        kinds = self.kinds(u)
        if kinds is None:
            return weight
        return np.concatenate([share * weight for share in kinds.share], axis=-1)

    def of_future_events(
        self, u: Floats, volume: Floats, columns: EventColumns
    ) -> tuple[Floats, Floats]:
        """Location and scatter `[n_draws, n_events]` of what is to come.

        Its winter or storm is none that is known: that, too, is in its scatter. `u` is
        `[n_draws, n_slots]`, `volume` (m3) `[n_events]`.
        """
        shifts, widens, _ = self.of_events(columns)
        temporary = ~np.array(self.persistent, dtype=np.bool_)
        own = np.sum(self.layout.spread_values(u)[:, temporary] ** 2, axis=1)[:, None]
        # Events that differ in nothing that friction knows are taken once.
        rows = np.column_stack([volume, *(design for _, design in (*shifts, *widens))])
        _, first, kind = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        shifts = [(place, design[first]) for place, design in shifts]
        widens = [(place, design[first]) for place, design in widens]
        location, scatter = self._located(u, volume[first, None], shifts, widens, own)
        return location[..., 0][:, kind.ravel()], scatter[..., 0][:, kind.ravel()]

    def _located(
        self,
        u: Floats,
        volume: Floats,
        shifts: list[tuple[slice, Floats]],
        widens: list[tuple[slice, Floats]],
        own: Floats,
        covariate: Floats | None = None,
    ) -> tuple[Floats, Floats]:
        """Location and scatter; `own` `[..., n_events]` is a further variance of log friction."""
        layout = self.layout
        law = layout.law
        if covariate is None:
            flat = law.log_friction(u[..., : len(law.coordinates)], volume.ravel())
            location = flat.reshape(*u.shape[:-1], *volume.shape)
        else:
            with np.errstate(over="ignore"):  # bounded then
                location = bounded(u[..., 0, None, None] - u[..., 1, None, None] * covariate)
        for place, design in shifts:
            location = location + (u[..., place] @ design.T)[..., None]
        log_scatter, least = self._log_scatter(u, volume, widens)
        if not layout.log_scatter:
            location = np.exp(location)
        scatter = np.zeros(location.shape)
        scatter += np.exp(np.minimum(np.maximum(log_scatter, least), MOST_LOG_SCATTER))
        if own.any():
            square = 1.0 if layout.log_scatter else location**2
            scatter = np.sqrt(scatter**2 + own[..., None] * square)
        return location, scatter

    def _log_scatter(
        self, u: Floats, volume: Floats, widens: list[tuple[slice, Floats]]
    ) -> tuple[Floats, float]:
        """Log of the scatter, of a shape that fits `[..., n_events, n_volumes]`, and its least."""
        layout = self.layout
        log_scatter, least = u[..., layout.scatter, None, None], LEAST_LOG_SCATTER
        if layout.scatter_slope is not None or widens:
            # Where it falls with volume it stops at the least that the nodes resolve.
            least = layout.slots[layout.scatter].low
        if layout.scatter_slope is not None:
            share = volume_share(volume, layout.reference_volume)
            log_scatter = log_scatter - u[..., layout.scatter_slope, None, None] * share
        for place, design in widens:
            log_scatter = log_scatter + (u[..., place] @ design.T)[..., None]
        return log_scatter, least

    def pulled(
        self,
        u: Floats,
        volume: Floats,
        events: EventFriction,
        scatter: Floats,
        pull: Floats,
        by_scatter: Floats,
    ) -> Floats:
        """Derivatives `[n_slots]` by the coordinates u `[n_slots]` that move location and scatter.

        Of a sum over events whose derivatives in m and in log σ are `pull` and `by_scatter`, each
        `[n_events, n_volumes]`, of every kind (`by_kind`), as is the `scatter` σ; 0 for other
        coordinates. Where friction is normal no event has an offset for itself.
        """
        kinds = self.kinds(u)
        if kinds is not None:
            steep = np.ones(2) if self.layout.log_scatter else np.exp(kinds.shift)
            pull = steep @ np.array(np.split(pull, 2, axis=1)).swapaxes(0, 1)
            by_scatter = np.sum(np.split(by_scatter, 2, axis=1), axis=0)
        layout = self.layout
        slopes = np.zeros(len(u))
        n = len(layout.law.coordinates)
        own = layout.spread_values(u)[:, None] ** 2 * events.plan.alone
        if own.any():
            # σ² is a sum, of which spreads have a part.
            by_variance = by_scatter / scatter[:, : volume.shape[1]] ** 2
            spreads = list(layout.spreads.values())
            slopes[spreads] = own @ np.sum(by_variance, axis=1) / u[spreads]
            by_scatter = by_scatter - np.sum(own, axis=0)[:, None] * by_variance
        if not layout.log_scatter:
            # m is μ itself.
            own = np.zeros(len(volume))
            pull = pull * self._located(u, volume, events.shifts, [], own)[0]
        by_law = layout.law.slopes(u[:n], volume.ravel())
        slopes[:n] = by_law @ pull.ravel()
        by_event = np.sum(pull, axis=1)
        for place, design in events.shifts:
            slopes[place] = by_event @ design
        # Where the scatter stands at a bound nothing moves it.
        raw, least = self._log_scatter(u, volume, events.widens)
        by_scatter = np.where((raw > least) & (raw < MOST_LOG_SCATTER), by_scatter, 0.0)
        slopes[layout.scatter] = np.sum(by_scatter)
        if layout.scatter_slope is not None:
            share = volume_share(volume, layout.reference_volume)
            slopes[layout.scatter_slope] = -np.sum(by_scatter * share)
        for place, design in events.widens:
            slopes[place] = np.sum(by_scatter, axis=1) @ design
        return slopes

    def shifted(self, location: Floats, shift: Floats) -> Floats:
        """The location with `shift` added to log friction."""
        return shifted(location, shift, self.layout.log_scatter)

    def draw(
        self, u: Floats, location: Floats, scatter: Floats, rng: np.random.Generator
    ) -> Floats:
        """One draw of μ, of whatever kind, for each location and scatter, of one shape.

        Coordinates u `[..., n_slots]` are one for all, or one for each of the last axis.
        """
        kinds = self.kinds(u)
        if kinds is not None:
            location = self.shifted(location, kinds.drawn(rng.uniform(size=location.shape)))
        noise = draws(rng, location.shape, self.student)
        return friction(location, scatter * noise, self.layout.log_scatter)


def friction_model(
    specification: Specification,
    effects: tuple[Effect, ...],
    arms: Arms | None = None,
    *,
    speeds: bool,
) -> FrictionModel:
    """The friction of a model with these effects, on whatever they act; as in `build_layout`."""
    layout = build_layout(specification, effects, arms, speeds=speeds)
    on_friction = tuple(
        e for e in effects if isinstance(e, FrictionEffect | ScatterEffect | GroupEffect)
    )
    return FrictionModel(layout, on_friction, specification.tails == "student")
