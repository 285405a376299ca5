"""All that the runouts, speeds and zones of one path follow from, built once.

Classes of future avalanches (`future_events`), draws of the fit in groups that share the runs of
the block, the runout curves of each group, and the friction of each draw, class and volume: with
the rate and the volumes of the path they are its `Avalanches`, of which `exceedance` is asked.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.effect import FrontEffect, LimitEffect, of_kind
from avahazard.effects.site import stop_places
from avahazard.hazard.exceedance import Avalanches, with_unseen
from avahazard.hazard.extremes import ANY_VOLUME_M3, EventVolumes, one_volume, with_volumes
from avahazard.hazard.frequency import N_DRAWS
from avahazard.hazard.future_events import FutureEvents, classes_of, classes_to_come
from avahazard.inference.fitted_model import FittedModel, table_groups
from avahazard.inference.likelihood.predicted import Values, front_ahead, fronts
from avahazard.inference.model.friction_model import FrictionKinds, FrictionModel
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.cells import Resistance
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.records.collection import Profile, Records, of_path
from avahazard.results.hazard import FarthestRecord, MapPoint


@dataclass(frozen=True, slots=True, eq=False)
class RecordedStops:
    """Recorded stops `x` (m) `[n_records]`, inf beyond the profile, with their dates."""

    x: Floats = field(default_factory=lambda: np.empty(0))
    dates: tuple[str | None, ...] = ()
    profile: Profile | None = None

    def farthest(self) -> FarthestRecord | None:
        """The stop farthest down, the latest of equals; None without records."""
        if not len(self.x):
            return None
        k = max(range(len(self.x)), key=lambda i: (self.x[i], self.dates[i] or ""))
        place = float(self.x[k])
        return FarthestRecord(place if np.isfinite(place) else None, self.dates[k])

    def beyond(self, x: float) -> int:
        """How many of them lie past a place x (m) on the profile."""
        return int(np.count_nonzero(self.x > x))

    def point(self, x: float) -> MapPoint | None:
        """The place x (m) on the map; None without coordinates, or off their line."""
        if self.profile is None or self.profile.on_map is None:
            return None
        (xy, crs), along = self.profile.on_map, self.profile.x_m
        # Coordinates in metres mean nothing without a system.
        if not crs or not along[0] <= x <= along[-1]:
            return None
        east, north = (float(np.interp(x, along, coordinate)) for coordinate in xy.T)
        return MapPoint(east, north, crs)


WORTH_A_NOTE = 0.05
"""Share of draws from which something is said of them."""
MAX_PARAMETERS = 4000
"""Posterior draws that the bounds of a volume take, thinned from those of the model."""
MAX_TABLES = 32
"""Groups of draws that the block is run for where effects on the motion have parameters."""


@dataclass(frozen=True, slots=True)
class Varying:
    """What makes a difference from avalanche to avalanche of a path, besides friction's scatter."""

    release: bool = False
    columns: bool = False
    volume: bool = True


class BlockGroups(NamedTuple):
    """Groups of draws alike in what shapes the motion of the block; `members` are their draws.

    Each is run at the median of its effects on the motion: with their parameters `values`, under
    `resistances`, along `curves` from each release of the site.
    """

    members: tuple[Ints, ...]
    values: tuple[Values, ...]
    resistances: tuple[Resistance, ...]
    curves: tuple[RunoutCurve, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PathDraws:
    """Draws `u` `[n_parameters, n_slots]`, in the order of their groups `group` `[n_parameters]`.

    `offset` `[n_parameters]` of log friction is the path's, None where the model does not know
    it; `tau` `[n_parameters]` the spread between paths, None without one; `sigma_m` as in
    `FittedModel`, `kinds` as in `FrictionModel`.
    """

    u: Floats
    group: Ints
    offset: Floats | None
    tau: Floats | None
    sigma_m: Floats | None
    kinds: FrictionKinds | None

    def shift(self, rng: np.random.Generator) -> Floats:
        """Offset of the path's log friction `[n_parameters]`; one is drawn where it has none."""
        if self.offset is not None:
            return self.offset
        if self.tau is None:
            return np.zeros(len(self.u))
        return np.asarray(self.tau * rng.standard_normal(len(self.tau)))


class VolumeFriction(NamedTuple):
    """Friction and runs of the avalanches of one volume.

    `location`, `scatter` `[n_parameters, n_classes]` as `FrictionModel.of_future_events`, without
    the path's offset; `curves` `[n_groups]` as in `Avalanches`.
    """

    location: Floats
    scatter: Floats
    curves: tuple[RunoutCurve, ...]


@dataclass(frozen=True, slots=True, eq=False)
class PathHazard:
    """One path by one model: the unit of work of `hazard` and `zones`, arrays all through.

    `avalanches` are all that come down it, of every volume, at the path's rate (once a year where
    that is not `rate_known`). `draws` are those for the bounds of single volumes, `at_volume` the
    friction of each (m3). Both take the curves of one set of runs. `offset_unknown`: paths differ
    by the model, and it does not know by how much this one does. `rising` says that friction
    may rise with volume.
    """

    path_id: str
    avalanches: Avalanches
    draws: PathDraws
    at_volume: Mapping[float, VolumeFriction]
    rate_known: bool
    varying: Varying
    offset_unknown: bool
    rising: Note | None = None
    recorded: RecordedStops = field(default_factory=RecordedStops)


def path_hazard(
    model: FittedModel,
    records: Records,
    path_id: str,
    volumes: EventVolumes | None,
    at: Sequence[float] = (),
    *,
    seed: int,
) -> PathHazard:
    """Apply a calibrated model to future avalanches on a path.

    `records` are those of the database, for the releases and columns of such avalanches.
    Otherwise as `hazard_of_events`.
    """
    # Of the path's own volumes: what is asked for besides must change no other row.
    mixed = _mixed(volumes, () if volumes is not None else at)
    middle = float(np.exp(np.median(mixed.log_volume)))
    by_columns = model.takes_event_columns
    selected = of_path(records, path_id)
    events = classes_to_come(records, path_id, middle, event_columns=by_columns)
    future = classes_of(replace(selected, events=events), model.columns)
    released = events[0].release_elevation_m is not None
    varying = Varying(released, by_columns, not model.ignores_volume)
    found = hazard_of_events(model, future, volumes, at, varying, seed=seed)
    rising = rising_friction(model.friction, future, found.draws.u, model.columns.log_volume)
    places = stop_places(future.site.smooth, selected.events)
    x = np.array([np.inf if place is None else place for place in places], np.float64)
    dates = tuple(event.date for event in selected.events)
    recorded = RecordedStops(x, dates, selected.profiles[0])
    return replace(found, rising=rising, recorded=recorded)


def hazard_of_events(
    model: FittedModel,
    future: FutureEvents,
    volumes: EventVolumes | None,
    at: Sequence[float] = (),
    varying: Varying = Varying(),
    *,
    seed: int,
) -> PathHazard:
    """What a path has by a model on its classes of future avalanches; the block is run here.

    `volumes` are the rate and volumes of its avalanches, None where nothing is known; `at` the
    volumes (m3) that bounds are wanted of. The posterior of the model is spread over the draws of
    `volumes`, which know nothing of each other.
    """
    groups = block_groups(model, future)
    draws = path_draws(model, groups, future.site.path.path_id, MAX_PARAMETERS)
    avalanches = _avalanches(model, future, groups, _mixed(volumes, at), seed)
    return PathHazard(
        path_id=future.site.path.path_id,
        avalanches=avalanches,
        draws=draws,
        at_volume=_at_volumes(model, future, groups, draws.u, avalanches.curves, at),
        rate_known=volumes is not None,
        varying=varying,
        offset_unknown=draws.tau is not None and draws.offset is None,
    )


def block_groups(model: FittedModel, future: FutureEvents) -> BlockGroups:
    """Run the block for all draws of a model, each group at its median effects on the motion."""
    layout, site = model.layout, future.site
    shaping = list(layout.tables)
    members = tuple(table_groups(model.draws[:, shaping], MAX_TABLES))
    values = []
    for group in members:
        middle = model.draws[group[0]].copy()
        middle[shaping] = np.median(model.draws[group][:, shaping], axis=0)
        values.append(layout.effect_values(middle))
    resistances = tuple(model.resistance(site, v) for v in values)
    curves = tuple(site.table(site.cells(resistance)) for resistance in resistances)
    return BlockGroups(members, tuple(values), resistances, curves)


def path_draws(
    model: FittedModel, groups: BlockGroups, path_id: str, n_parameters: int
) -> PathDraws:
    """At most `n_parameters` of the draws of a model, thinned, for a path."""
    order = np.concatenate(groups.members)
    group = np.repeat(np.arange(len(groups.members)), [len(m) for m in groups.members])
    taken = np.isin(order, model.thinned(min(len(order), n_parameters)))
    chosen = order[taken]
    u = model.draws[chosen]
    # The paths', if any: winters and storms do not last.
    persistent = [g for g, stays in enumerate(model.friction.persistent) if stays]
    tau = model.layout.spread_values(u)[:, persistent]
    offset = model.offsets.get(path_id)
    return PathDraws(
        u=u,
        group=group[taken],
        offset=None if offset is None else offset[chosen],
        tau=np.sqrt(np.sum(tau**2, axis=1)) if persistent else None,
        sigma_m=None if model.sigma_m is None else model.sigma_m[chosen],
        kinds=model.friction.kinds(u),
    )


def friction_of_volumes(
    friction: FrictionModel, future: FutureEvents, u: Floats, volume: Floats
) -> tuple[Floats, Floats]:
    """Location and scatter `[n_parameters, n_classes, n_volumes]` at volumes (m3) `[n_volumes]`."""
    shape = (len(u), future.n_classes, len(volume))
    every = np.tile(volume, future.n_classes)
    location, scatter = friction.of_future_events(u, every, future.at_volumes(volume))
    return location.reshape(shape), scatter.reshape(shape)


def rising_friction(
    friction: FrictionModel, future: FutureEvents, u: Floats, log_volume: Floats
) -> Note | None:
    """Says that friction rises with volume in some draws `u` `[n_parameters, n_slots]`, if so.

    From the smallest to the largest of log volumes `[n_events]` (nan: not recorded).
    """
    known = log_volume[np.isfinite(log_volume)]
    if not len(known) or np.ptp(known) == 0.0:
        return None
    ends = np.exp([known.min(), known.max()])
    location, _ = friction_of_volumes(friction, future, u, ends)
    rises = location[:, :, 1].mean(axis=1) > location[:, :, 0].mean(axis=1)
    share, (smallest, largest) = float(np.mean(rises)), (float(f"{v:.2g}") for v in ends)
    if share <= WORTH_A_NOTE:
        return None
    return Note("rising_friction", share=share, smallest=smallest, largest=largest)


def limits_of_sight(model: FittedModel, future: FutureEvents, values: Sequence[Values]) -> Floats:
    """Elevation (m) above which no stop is seen `[n_groups]`, by effects' `values`; or nan."""
    own = future.site.path.observed_below_m
    found = np.full(len(values), np.nan if own is None else own)
    for effect in of_kind(model.effects, LimitEffect):
        found = np.array([effect.limit(future.columns, v[effect.key])[0] for v in values])
    return found


def _avalanches(
    model: FittedModel, future: FutureEvents, groups: BlockGroups, volumes: EventVolumes, seed: int
) -> Avalanches:
    path_id, n = future.site.path.path_id, len(volumes.rate)
    draws = path_draws(model, groups, path_id, n)
    of_all = friction_of_volumes(model.friction, future, draws.u, np.exp(volumes.log_volume))
    location, scatter = model.friction.by_kind(draws.u, *of_all)
    kind_share = np.ones((len(draws.u), 1)) if draws.kinds is None else draws.kinds.share
    shift = draws.shift(generator(seed, "avalanches", path_id))[:, None, None]
    location = model.friction.shifted(location, shift)
    # Fewer draws of the model than of the volumes serve several times.
    again = slice(None) if len(draws.u) == n else np.arange(n) * len(draws.u) // n
    ahead = tuple(front_ahead(future.columns, model.effects, v) for v in groups.values)
    known = Avalanches(
        site=future.site,
        release=future.release,
        volumes=volumes,
        class_share=np.full(future.n_classes, 1.0 / future.n_classes),
        kind_share=kind_share[again],
        location=location[again],
        scatter=scatter[again],
        group=draws.group[again],
        curves=_fronts(future, groups, ahead),
        resistances=groups.resistances,
        ahead=ahead,
        in_log=model.layout.log_scatter,
        student=model.friction.student,
        sigma_m=None if draws.sigma_m is None else draws.sigma_m[again],
    )
    return with_unseen(known, limits_of_sight(model, future, groups.values))


def _fronts(
    future: FutureEvents, groups: BlockGroups, ahead: Sequence[Floats]
) -> tuple[RunoutCurve, ...]:
    """Where the front of each class stops by each group, `ahead` (m) `[n_groups][n_classes]`."""
    return tuple(
        fronts(future.site, curve[future.release], advance)
        for curve, advance in zip(groups.curves, ahead, strict=True)
    )


def _at_volumes(
    model: FittedModel,
    future: FutureEvents,
    groups: BlockGroups,
    u: Floats,
    curves: tuple[RunoutCurve, ...],
    at: Sequence[float],
) -> dict[float, VolumeFriction]:
    """Friction of each of the volumes `at` (m3); `curves` are those of any volume."""
    if not at:
        return {}
    found: dict[float, VolumeFriction] = {}
    different = tuple(dict.fromkeys(at))
    location, scatter = friction_of_volumes(model.friction, future, u, np.array(different))
    for k, volume in enumerate(different):
        own = curves
        # Runs know nothing of volumes; only how far the front is ahead may.
        if of_kind(model.effects, FrontEffect):
            columns = future.at_volumes(np.array([volume]))
            ahead = [front_ahead(columns, model.effects, v) for v in groups.values]
            own = _fronts(future, groups, ahead)
        found[volume] = VolumeFriction(location[:, :, k], scatter[:, :, k], own)
    return found


def _mixed(volumes: EventVolumes | None, at: Sequence[float]) -> EventVolumes:
    """All volumes, with nodes at those that bounds are wanted of."""
    known = volumes or one_volume([*at, ANY_VOLUME_M3][0], N_DRAWS)
    return with_volumes(known, np.log(np.asarray(at, np.float64)))
