"""The parameters of a model: the order in which samplers see them, and what people read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Bools, Floats, Ints
from avahazard.effects.effect import Effect, GroupEffect, KindsEffect, Parameter, shapes_tables
from avahazard.inference.model.laws import Law, law
from avahazard.inference.model.specification import GivenPrior, Specification


class Arms(NamedTuple):
    """Arms of a star of exact tables, by slot name.

    `points` along each, the centre first. `along` has by what the slots of others move where that
    one moves by 1: stars turn with the posterior, whose coordinates go together. `beside` are
    places on each of points beside the arms.
    """

    points: Mapping[str, Sequence[float]]
    along: Mapping[str, Mapping[str, float]] = MappingProxyType({})
    beside: Mapping[str, Sequence[float]] = MappingProxyType({})


SCATTER_CENTRE = 0.15
"""Prior centre of the scatter of log friction: the paper's Gibbs fit has 0.158."""
MIN_SCATTER_SHARE = 0.15
"""Least scatter against that centre: nodes over friction are close enough for it."""
MIN_SPREAD = 1e-3
"""Least spread between groups of events, on log friction."""
WRONG_SHARE_NAME, TRACK_SCATTER_NAME = "wrong_share", "track_sigma"
"""As people read them."""
WRONG_SHARE, LEAST_WRONG, MOST_WRONG = 0.02, 1e-3, 0.4
"""Share of grossly wrong records that is thought of before (its log has standard deviation 1), and
its bounds: where half of the records are wrong, nothing shows which half."""
TRACK_SLOT = "log track sigma"
TRACK_SCATTER = 0.5 * SCATTER_CENTRE
"""Prior centre of the scatter of friction along a track, that of friction between events (of
frictions about 0.5); its log has standard deviation 1."""
N_ARM = 4
"""Points of an arm of the first star, whose reach is all of a range."""
TRACK_RANGE = (float(np.log(0.005)), float(np.log(0.6)))
"""Range of the log of that scatter."""


def scatter_centre(in_log: bool) -> float:
    """Prior centre of the scatter, of log friction or of friction itself."""
    return SCATTER_CENTRE if in_log else 0.5 * SCATTER_CENTRE


def least_scatter(in_log: bool) -> float:
    """The least that the scatter of friction can be."""
    return MIN_SCATTER_SHARE * scatter_centre(in_log)


@dataclass(frozen=True, slots=True)
class Slot:
    """One coordinate: a normal prior cut to [low, high]; an `arm` if it shapes tables (`Arms`).

    The parameter that people read is the coordinate times `scale`, so that samplers move in
    coordinates of order one; at `neutral` it is `neutral_value` to the last bit. With
    `lognormal`, `mean` and `sd` are those of the log of the coordinate, which is over 0.
    """

    name: str
    unit: str
    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf
    arm: tuple[float, ...] = ()
    neutral: float = np.nan
    scale: float = 1.0
    neutral_value: float = np.nan
    lognormal: bool = False
    along: Mapping[str, float] = field(default_factory=dict)
    beside: tuple[float, ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """The range in the coordinate, or its log, that has the normal prior; in its sds."""
        low, high = np.log([self.low, self.high]) if self.lognormal else (self.low, self.high)
        return float((low - self.mean) / self.sd), float((high - self.mean) / self.sd)


@dataclass(frozen=True, eq=False)
class Layout:
    """Coordinates `[n_slots]`: law, log scatter (and its slope), effects, speed.

    With Student's tails, the log share of wrong records is at `wrong_share`.
    `places` maps an effect's key to its slots, `spreads` that of an effect on groups of events to
    the slot of their spread; `kinds` are those of the share and the shift of a second kind of
    avalanche; `tables` are the slots that shape the tables. `law_correlation`
    `[n_coordinates, n_coordinates]` is that of the law's prior, None where it is independent.
    """

    law: Law
    slots: tuple[Slot, ...]
    scatter: int
    scatter_slope: int | None
    reference_volume: float
    spreads: dict[str, int]
    kinds: slice | None
    wrong_share: int | None
    track_scatter: int | None
    places: dict[str, slice]
    tables: tuple[int, ...]
    log_scatter: bool
    law_correlation: Floats | None = None

    @cached_property
    def low(self) -> Floats:
        """Lower bounds `[n_slots]`: of the ranges, and of what the star reaches."""
        return np.asarray(np.maximum(self.ranges[0], self._reached[0]))

    @cached_property
    def high(self) -> Floats:
        """Upper bounds `[n_slots]`."""
        return np.asarray(np.minimum(self.ranges[1], self._reached[1]))

    @cached_property
    def ranges(self) -> Floats:
        """Ends of the ranges of the parameters themselves, `[2, n_slots]`."""
        return np.array([[s.low, s.high] for s in self.slots]).T

    @property
    def arms(self) -> Arms:
        """The arms of its star."""
        armed = [slot for slot in self.slots if slot.arm]
        along = {s.name: s.along for s in armed if s.along}
        beside = {s.name: s.beside for s in armed if s.beside}
        return Arms({s.name: s.arm for s in armed}, along, beside)

    @cached_property
    def axes(self) -> Ints:
        """Slots with an arm, of what shapes the tables, `[n_axes]`."""
        return np.array([k for k, slot in enumerate(self.slots) if slot.arm], np.int64)

    @cached_property
    def arm_ends(self) -> Floats:
        """Ends of the arms on them, `[2, n_slots]`; of other slots those of their range."""
        arms = [s.arm or (s.low, s.high) for s in self.slots]
        return np.array([[min(arm), max(arm)] for arm in arms]).T

    @cached_property
    def turn(self) -> Floats:
        """What coordinates move by along each arm (or slot), `[n_slots, n_slots]`."""
        index = {slot.name: k for k, slot in enumerate(self.slots)}
        turn = np.eye(len(self.slots))
        for k, slot in enumerate(self.slots):
            for name, by in slot.along.items():
                turn[index[name], k] = by
        return turn

    def on_arms(self, u: Floats) -> Floats:
        """Places on the arms of coordinates u, both `[..., n_slots]`."""
        return u if self._turned_back is None else np.asarray(u @ self._turned_back.T)

    def from_arms(self, places: Floats) -> Floats:
        """Coordinates of places on the arms, both `[..., n_slots]`."""
        return places if self._turned_back is None else np.asarray(places @ self.turn.T)

    def within(self, u: Floats) -> Bools:
        """Whether coordinates u `[..., n_slots]` are in their ranges, and within the star."""
        inside = np.all((u >= self.low) & (u <= self.high), axis=-1)
        if self._turned_back is not None:
            places, (low, high) = self.on_arms(u), self.arm_ends
            off = 1e-9 * (high - low)
            off = np.where(np.isfinite(off), off, 0.0)
            inside &= np.all((places >= low - off) & (places <= high + off), axis=-1)
        return np.asarray(inside)

    @cached_property
    def _turned_back(self) -> Floats | None:
        """The inverse of `turn`, None where each arm moves its own slot alone."""
        turned = any(slot.along for slot in self.slots)
        return np.asarray(np.linalg.inv(self.turn)) if turned else None

    @cached_property
    def _reached(self) -> Floats:
        """What the star reaches, `[2, n_slots]`; no end where there is no arm."""
        reached = np.tile([[-np.inf], [np.inf]], len(self.slots))
        both = self.turn[:, self.axes] * self.arm_ends[:, None, self.axes]
        ends = both.min(axis=0).sum(axis=1), both.max(axis=0).sum(axis=1)
        reached[:, self.axes] = np.array(ends)[:, self.axes]
        return reached

    def log_prior(self, u: Floats) -> Floats:
        """Log density of the prior at coordinates u `[..., n_slots]`, up to a constant `[...]`."""
        z = self._standard(u)
        squares = np.sum(z * z, axis=-1)
        if self._in_log:
            squares = squares + 2.0 * np.sum(np.log(u[..., self._in_log]), axis=-1)
        if self._law_precision is not None:
            of_law = z[..., : len(self._law_precision)]
            squares = squares + np.sum((of_law @ self._law_precision - of_law) * of_law, axis=-1)
        return np.asarray(-0.5 * squares)

    def prior_slopes(self, u: Floats) -> Floats:
        """Derivatives `[n_slots]` of `log_prior` at u `[n_slots]`."""
        z = self._standard(u)
        if self._law_precision is not None:
            n = len(self._law_precision)
            z[:n] = self._law_precision @ z[:n]
        slopes = np.asarray(-z / self._prior[1])
        slopes[self._in_log] = (slopes[self._in_log] - 1.0) / u[self._in_log]
        return slopes

    def _standard(self, u: Floats) -> Floats:
        """What has a standard normal prior `[..., n_slots]`: coordinates, or their logs, scaled."""
        if self._in_log:
            u = u.copy()
            u[..., self._in_log] = np.log(u[..., self._in_log])
        mean, sd = self._prior
        return np.asarray((u - mean) / sd)

    @property
    def logs(self) -> tuple[int, ...]:
        """Slots whose coordinate is the log of what people read."""
        found = (self.scatter, self.wrong_share, self.track_scatter)
        return tuple(k for k in found if k is not None)

    def beside_the_law(self) -> dict[str, int]:
        """The slots of the parameters that are not the law's, by the names that people read."""
        found: dict[str, int | None] = {"sigma": self.scatter, "sigma_n": self.scatter_slope}
        for place in self.places.values():
            found |= {self.slots[k].name: k for k in range(place.start, place.stop)}
        found |= {f"{key}.{self.slots[k].name}": k for key, k in self.spreads.items()}
        found |= {WRONG_SHARE_NAME: self.wrong_share, TRACK_SCATTER_NAME: self.track_scatter}
        return {name: k for name, k in found.items() if k is not None}

    def track_sigma(self, u: Floats) -> float:
        """Scatter of friction along the tracks at coordinates u `[n_slots]`; 0 without speeds."""
        return 0.0 if self.track_scatter is None else float(np.exp(u[self.track_scatter]))

    def spread_values(self, u: Floats) -> Floats:
        """Spreads of log friction at coordinates u `[..., n_slots]`, `[..., n_groupings]`."""
        slots = list(self.spreads.values())
        return np.asarray(u[..., slots] * np.array([self.slots[k].scale for k in slots]))

    def effect_values(self, u: Floats) -> dict[str, Floats]:
        """Parameter values by effect key; exactly neutral where the coordinate is."""
        return {
            key: np.array([self._value(k, float(u[k])) for k in range(place.start, place.stop)])
            for key, place in self.places.items()
        }

    def _value(self, k: int, u: float) -> float:
        slot = self.slots[k]
        return slot.neutral_value if u == slot.neutral else u * slot.scale

    @cached_property
    def _in_log(self) -> list[int]:
        return [k for k, slot in enumerate(self.slots) if slot.lognormal]

    @cached_property
    def _prior(self) -> Floats:
        """Means and standard deviations of the normal priors, `[2, n_slots]`."""
        return np.array([[s.mean, s.sd] for s in self.slots]).T

    @cached_property
    def _law_precision(self) -> Floats | None:
        if self.law_correlation is None:
            return None
        return np.asarray(np.linalg.inv(self.law_correlation), np.float64)

    def readable(self, u: Floats) -> dict[str, tuple[Floats, str]]:
        """Values and unit by name of coordinates u `[..., n_slots]` (docs/results.md)."""
        natural = self.law.to_natural(u[..., : len(self.law.coordinates)])
        result = {
            name: (natural[..., k], unit)
            for k, (name, unit) in enumerate(zip(self.law.names, self.law.units, strict=True))
        }
        for name, k in self.beside_the_law().items():
            slot, at = self.slots[k], u[..., k]
            value = np.exp(at) if k in self.logs else at * slot.scale
            if k == self.scatter_slope:
                value = at / self.reference_volume
            result[name] = (value, slot.unit)
        return result


def arm_between(centre: float, low: float, high: float, n: int) -> tuple[float, ...]:
    """A centre and n more points from low to high, evenly on each side; none where all are one."""
    if not low < high:
        return ()
    share = (centre - low) / (high - low)
    below = int(np.clip(round(n * share), centre > low, n - (centre < high)))
    sides = (
        np.linspace(low, centre, below, endpoint=False),
        np.linspace(high, centre, n - below, endpoint=False),
    )
    return centre, *np.concatenate(sides).tolist()


def with_arms(layout: Layout, arms: Arms) -> Layout:
    """The layout with the arms of some slots replaced by name; what it lacks moves along none."""
    known = {slot.name for slot in layout.slots}
    same = {slot.name for slot in layout.slots if slot.arm} == set(arms.points)
    along = {
        name: {other: by for other, by in moved.items() if other in known}
        for name, moved in arms.along.items()
    }
    slots = [
        replace(
            s,
            arm=tuple(arms.points[s.name]),
            along=along.get(s.name, s.along),
            beside=tuple(arms.beside.get(s.name, ())) if same else (),
        )
        if s.name in arms.points
        else s
        for s in layout.slots
    ]
    return replace(layout, slots=tuple(slots))


def build_layout(
    specification: Specification,
    effects: tuple[Effect, ...],
    arms: Arms | None = None,
    *,
    speeds: bool,
) -> Layout:
    """The coordinates of a model; `arms` replace those of effects, `speeds` were measured."""
    chosen = law(specification.law)
    # A prior is that of one law; a model of another law has that law's own.
    told = specification.prior
    prior = told if told is not None and told.law == chosen.name else None
    mean, sd = (chosen.prior_mean, chosen.prior_sd) if prior is None else (prior.mean, prior.sd)
    slots = [
        Slot(name, "", float(m), float(s))
        for name, m, s in zip(chosen.coordinates, mean, sd, strict=True)
    ]

    def add(slot: Slot) -> int:
        slots.append(slot)
        return len(slots) - 1

    log_scatter = specification.distribution == "lognormal"
    centre, least = np.log([scatter_centre(log_scatter), least_scatter(log_scatter)]).tolist()
    unit = "" if log_scatter else "friction"
    scatter = add(Slot("log sigma", unit, centre, 1.0, least, 2.0))
    slope = None
    if specification.scatter == "volume":
        per_volume = 1.0 / specification.reference_volume_m3
        slope = add(Slot("sigma_n", "1/m3", 0.0, 1.0, scale=per_volume))
    places: dict[str, slice] = {}
    spreads: dict[str, int] = {}
    kinds = None
    for effect in effects:
        if isinstance(effect, GroupEffect):
            # It goes by the parameter's own name, under which draws are stored.
            p, least = effect.parameters[0], MIN_SPREAD / effect.parameters[0].prior_sd
            spreads[effect.key] = add(Slot(p.name, p.unit, 0.0, 1.0, least, 10.0, scale=p.prior_sd))
            continue
        places[effect.key] = slice(len(slots), len(slots) + len(effect.parameters))
        slots += [_slot(effect, p) for p in effect.parameters]
        if isinstance(effect, KindsEffect):
            kinds = places[effect.key]
    wrong_share = None
    if specification.tails == "student":
        middle, *bounds = np.log([WRONG_SHARE, LEAST_WRONG, MOST_WRONG]).tolist()
        wrong_share = add(Slot("log wrong share", "of the records", middle, 1.0, *bounds))
    tables = tuple(k for k, s in enumerate(slots) if s.arm)
    track_scatter = None
    if speeds:
        middle = float(np.log(TRACK_SCATTER))
        arm = arm_between(middle, *TRACK_RANGE, N_ARM)
        track_scatter = add(Slot(TRACK_SLOT, "friction", middle, 1.0, *TRACK_RANGE, arm))
    layout = Layout(
        law=chosen,
        slots=tuple(slots),
        scatter=scatter,
        scatter_slope=slope,
        reference_volume=specification.reference_volume_m3,
        spreads=spreads,
        kinds=kinds,
        wrong_share=wrong_share,
        track_scatter=track_scatter,
        places=places,
        tables=tables,
        log_scatter=log_scatter,
        law_correlation=None if prior is None else prior.correlation,
    )
    layout = replace(layout, slots=with_given(layout, specification.given))
    return layout if arms is None else with_arms(layout, arms)


def _slot(effect: Effect, p: Parameter) -> Slot:
    name = effect.key if p.name == "" else f"{effect.key}.{p.name}"
    scale = p.prior_sd
    mean, low, high = p.prior_mean / scale, p.low / scale, p.high / scale
    arm = arm_between(mean, low, high, N_ARM) if shapes_tables(effect) else ()
    return Slot(name, p.unit, mean, 1.0, low, high, arm, p.neutral / scale, scale, p.neutral)


def with_given(layout: Layout, given: Sequence[GivenPrior]) -> tuple[Slot, ...]:
    """The slots, with the priors that are given for those that are not of the law."""
    slots, places = list(layout.slots), layout.beside_the_law()
    for told in given:
        if told.name not in places:
            continue
        k = places[told.name]
        mean, sd = in_coordinate(layout, k, told)
        slots[k] = replace(slots[k], mean=mean, sd=sd, lognormal=k in layout.spreads.values())
    return tuple(slots)


def in_coordinate(layout: Layout, k: int, told: GivenPrior) -> tuple[float, float]:
    """Mean and standard deviation in the coordinate of slot k, or in its log where it is a spread.

    A spread keeps its own coordinate, in which it may come near 0.
    """
    if k in layout.logs:
        return told.in_log
    scale = layout.slots[k].scale
    scaled = GivenPrior(told.name, told.mean / scale, told.sd / scale)
    return scaled.in_log if k in layout.spreads.values() else (scaled.mean, scaled.sd)
