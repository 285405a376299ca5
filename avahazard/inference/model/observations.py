"""Records in the form that the likelihood runs over: sites, columns, and what was measured."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.stats import rankdata

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import (
    FALL_HEIGHT,
    EventColumns,
    MeasuredTrack,
    build_columns,
    counted,
)
from avahazard.effects.site import (
    SimulatedSite,
    Site,
    build_site,
    release_places,
    simulated_site,
    stop_place,
)
from avahazard.engine import spread_map
from avahazard.inference.model.choices import BLOCK
from avahazard.inference.model.release_errors import carried_error, stated_release_sigma
from avahazard.inference.model.volumes import VolumeNodes, volume_nodes
from avahazard.physics.cells import GRAVITY
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.records.collection import (
    H_OVER_L_REL_SIGMA,
    Event,
    Path,
    Profile,
    Records,
    Simulation,
    Speed,
    no_profile,
)
from avahazard.records.errors import AvahazardError


def height_over_length(
    events: Sequence[Event], sites: Sequence[Site], of_path: Mapping[str, list[int]], release: Ints
) -> Floats:
    """H/L from release to recorded stop `[n_events]`, or nan; `of_path` are events by path."""
    ratio = np.full(len(events), np.nan)
    for i, e in enumerate(events):
        if e.path_id is None and e.fall_height_m and e.runout_length_m:
            ratio[i] = e.fall_height_m / e.runout_length_m
    for site in sites:
        x, y = site.terrain_x, site.heights()
        # Lowest so far, falling: its negative is sorted for the search.
        fallen = -np.minimum.accumulate(y)
        for i in of_path[site.path.path_id]:
            e = events[i]
            stop, start = e.runout_x_m, float(site.release_x[release[i]])
            if stop is None and e.runout_elevation_m is not None:
                place = int(np.searchsorted(fallen, -e.runout_elevation_m))
                stop = float(x[min(place, len(x) - 1)])
            if stop is not None and stop > start and not e.left_profile:
                top, bottom = np.interp([start, stop], x, y)
                ratio[i] = (top - bottom) / (stop - start)
    return ratio


FRICTION_CORRELATION_M = 100.0
"""Length over which friction stays alike along a track: about that of a terrain step."""


class SpeedRecord(MeasuredTrack):
    """A measured track, and how friction that varies along it moves the squares of its speeds."""

    @cached_property
    def share(self) -> Floats:
        """Of the way to the stop, what lies above each place `[n_speeds]`."""
        return self._way / self._length

    @cached_property
    def spread(self) -> Floats:
        """Covariance `[n_speeds, n_speeds]` (m⁴/s⁴) of r for s = 1 (`track_spread`)."""
        return track_spread(self._way, self._length)

    @cached_property
    def root(self) -> Floats:
        """A square root `[n_speeds, n_speeds]`: times itself transposed it is the `spread`."""
        values, vectors = np.linalg.eigh(self.spread)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))

    @property
    def _length(self) -> float:
        return max(self.stop_x - self.release_x, 1.0)

    @property
    def _way(self) -> Floats:
        return np.maximum(self.x - self.release_x, 0.0)


def track_spread(way: Floats, length: float) -> Floats:
    """Covariance of r for s = 1 at distances `way` `[n_speeds]` (m) on a track of this length.

    The friction of an avalanche goes up and down along its track about the mean that its stop asks
    for by ε(x), with standard deviation s and alike over `FRICTION_CORRELATION_M`. The square of
    speed differs from that of the block by r(x) = -2 g ∫ (ε - mean of ε) dx, over horizontal
    distance from the release, where it is 0, to the stop, where it is 0 again.
    """
    # Covariance of ∫ ε dx up to two places, for s = 1: that of ε is exp(-|Δx| / scale).
    b, scale = np.append(way, length), FRICTION_CORRELATION_M
    a = b[:, None]
    rest = 1.0 - np.exp(-a / scale) - np.exp(-b / scale) + np.exp(-np.abs(a - b) / scale)
    covariance = 2.0 * scale * np.minimum(a, b) - scale**2 * rest
    # Less the mean along the track: r is 0 at its end.
    tie = np.eye(len(b))[:-1]
    tie[:, -1] = -way / length
    return np.ascontiguousarray((2.0 * GRAVITY) ** 2 * tie @ covariance @ tie.T)


def speed_records(
    records: Records, columns: EventColumns, sites: Sequence[Site], release: Ints
) -> tuple[SpeedRecord, ...]:
    """Speeds by event, in the order of the events; elevations become the first place there."""
    of_event: dict[str, list[Speed]] = {}
    for speed in records.speeds:
        of_event.setdefault(speed.event_id, []).append(speed)
    result = []
    for i, event in enumerate(records.events):
        measured = of_event.get(event.event_id)
        if measured is None or event.path_id is None:
            continue
        site = sites[columns.path_index[i]]
        stop = stop_place(site.smooth, event)
        places = release_places(site.smooth, [s.elevation_m for s in measured])
        x = [x if s.x_m is None else s.x_m for s, x in zip(measured, places, strict=True)]
        order = np.argsort(x, kind="stable")
        result.append(
            SpeedRecord(
                event=i,
                x=np.array(x)[order],
                speed=np.array([s.speed_m_s for s in measured])[order],
                sigma=np.array([s.speed_sigma_m_s for s in measured])[order],
                release_x=float(site.release_x[release[i]]),
                stop_x=site.smooth.x_max if stop is None else min(stop, site.smooth.x_max),
                left=stop is None,
            )
        )
    return tuple(result)


ELEVATION, PLACE, LENGTH, LEFT = 0, 1, 2, 3
"""What was recorded: the elevation of the stop, its x, a runout length, or that it left."""
MANY_PATHS = 200
"""Paths from which on it pays to give their grounds to other processes."""
KEPT_SITES = 2000
"""Sites that keep terrains where effects move the block: it runs anew for each of their values
(0.12 MB a site; to make one again takes half as long as the runs)."""


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """Events `[n_events]` with the sites that they ran on.

    `kind` says what `observed` (m) is, `sigma` (m) is its error: that of the measurement and, where
    one is stated, that of the release carried to the record (`release_sigma`, m; to the profile's
    end where the avalanche left). `leaving_sigma` is the error of the release carried to the log of
    the friction under which the block leaves. `release` indexes `site.release_x` of the event's
    site; `fall_height` (m) is set for events without a profile. Where H/L is all that is known
    (`in_ratio`) the fall is 1, and `observed` is L/H. `limit` (m) is the elevation above which a
    stop is undetected, nan without a limit. `outcomes` are columns that are the stop in another
    form, with their rank correlation; `columns` has none of them.
    """

    sites: tuple[Site, ...]
    columns: EventColumns
    kind: Ints
    observed: Floats
    sigma: Floats
    release_sigma: Floats
    leaving_sigma: Floats
    release: Ints
    fall_height: Floats
    limit: Floats
    volumes: VolumeNodes
    speeds: tuple[SpeedRecord, ...]
    in_ratio: bool = False
    outcomes: Mapping[str, float] = field(default_factory=dict)

    def as_recorded(self, record: Floats) -> Floats:
        """Records `[n_events, …]` in their own unit: m, or H/L instead of the L/H held here."""
        return 1.0 / record if self.in_ratio else record

    def recorded_sigma(self, sigma: Floats) -> Floats:
        """Errors of the records `[n_events]` in their own unit."""
        return sigma / self.observed**2 if self.in_ratio else sigma

    @property
    def n_events(self) -> int:
        """Number of events."""
        return len(self.observed)


def build_observations(
    records: Records,
    prior: Observations | None = None,
    forward: str = BLOCK,
    among: EventColumns | None = None,
) -> Observations:
    """Arrange the records for the likelihood.

    With `prior`, volumes are read in the light of the volumes of those (prediction), and the
    profiles of its paths, which are the same, are not regularised again; the events are counted
    `among` others, by default those of `prior` or themselves. Where `forward`, or the model of
    `prior`, is no block but a flow model, its stored runs stand in the place of the block.
    Raises `AvahazardError` where an event's path has no profile, or some events have H/L alone and
    others, here or in `prior`, metres, or runs are missing.
    """
    events = records.events
    require_one_scale(events, prior)
    paths = {p.path_id: p for p in records.paths}
    profiles = {p.path_id: p for p in records.profiles}
    of_path: dict[str, list[int]] = {}
    for i, event in enumerate(events):
        if event.path_id is not None:
            of_path.setdefault(event.path_id, []).append(i)
    require_profiles(name for name in of_path if name not in profiles)
    known = {} if prior is None else {site.path.path_id: site.smooth for site in prior.sites}
    new = [profiles[name] for name in of_path if name not in known]
    known |= {profile.path_id: smooth for profile, smooth in zip(new, _grounds(new), strict=True)}
    runs = runs_by_path(records, prior, forward)
    sites: list[Site] = []
    release = np.zeros(len(events), dtype=np.int64)
    elevation = np.array([event.release_elevation_m for event in events], np.float64)
    for name, selected in of_path.items():
        ground, own = (paths[name], profiles[name], known[name]), [events[i] for i in selected]
        if runs is None:
            site, rows = released_site(*ground, own, keeps=len(sites) < KEPT_SITES)
        else:
            site, rows = _simulated(*ground, own, runs)
        sites.append(site)
        release[selected], elevation[selected] = rows, release_elevations(site)[rows]
    ratio = height_over_length(events, sites, of_path, release)
    columns = build_columns(events, paths, elevation, ratio)
    if among is None:
        among = columns if prior is None else prior.columns
    columns = replace(columns, made=counted(columns, among))
    return _arranged(records, prior, tuple(sites), release, columns)


def released_site(
    path: Path,
    profile: Profile,
    smooth: SmoothProfile,
    events: Sequence[Event],
    *,
    keeps: bool = True,
) -> tuple[Site, Ints]:
    """The path cut at the releases of its events, and which of these `[n_events]` is each one's."""
    own = path.release_elevation_m
    start = [own if e.release_elevation_m is None else e.release_elevation_m for e in events]
    different = list(dict.fromkeys(start))
    place = dict(zip(different, release_places(smooth, different), strict=True))
    site = build_site(path, profile, smooth, list(place.values()), keeps=keeps)
    return site, np.searchsorted(site.release_x, [place[z] for z in start])


def release_elevations(site: Site) -> Floats:
    """Elevations (m) of the releases of a site `[n_releases]`."""
    return np.array([float(site.smooth.height(x)) for x in site.release_x])


Runs = Mapping[str, Sequence[Simulation]]
"""Runs of a flow model, by path."""


def runs_by_path(records: Records, prior: Observations | None, forward: str) -> Runs | None:
    """The runs in the place of the block; None where it is the block that runs."""
    if prior is not None:
        sites = [site for site in prior.sites if isinstance(site, SimulatedSite)]
        return {site.path.path_id: site.runs for site in sites} if sites else None
    if forward == BLOCK:
        return None
    runs: dict[str, list[Simulation]] = {}
    for one in records.simulations:
        if one.engine == forward:
            runs.setdefault(one.path_id, []).append(one)
    return runs


def _simulated(
    path: Path, profile: Profile, smooth: SmoothProfile, events: Sequence[Event], runs: Runs
) -> tuple[SimulatedSite, Ints]:
    """The path with its runs, and the row of each event; of unknown volume a middle one."""
    if path.path_id not in runs:
        raise AvahazardError(
            f"No runs of a flow model are stored for path {path.path_id}.",
            f"Make them: avahazard simulate {path.path_id}; or leave the path out.",
        )
    selected = runs[path.path_id]
    middle = float(np.exp(np.mean(np.log([one.volume_m3 for one in selected]))))
    volume, rows = np.unique([e.volume_m3 or middle for e in events], return_inverse=True)
    return simulated_site(path, profile, smooth, volume, selected), rows


LIKE_THE_STOP, FEWEST_LIKE_IT = 0.98, 10
"""Rank correlation with the stop above which a column is the stop, and events that show it."""


def outcome_columns(columns: EventColumns, kind: Ints, observed: Floats) -> dict[str, float]:
    """Columns that order events as their stops do, given the path, with their rank correlation.

    Such a column (H/L, angle of reach, distance travelled) explains every runout without
    information. What is `observed` `[n_events]` is compared, and H/L, each among events of one path
    and `kind`.
    """
    group = 10 * columns.path_index + kind
    found = {}
    for name, values in columns.numbers.items():
        if name == FALL_HEIGHT:
            continue
        stops = observed, columns.height_over_length
        ranks = [_rank_correlation(values, stop, group) for stop in stops]
        strongest = max(ranks, key=abs)
        if abs(strongest) >= LIKE_THE_STOP:
            found[name] = strongest
    return found


def _rank_correlation(values: Floats, stop: Floats, group: Ints) -> float:
    """Spearman's, of ranks within groups; 0 where too few events show it."""
    known = np.flatnonzero(np.isfinite(values) & np.isfinite(stop))
    parts = [known[group[known] == g] for g in np.unique(group[known])]
    parts = [part for part in parts if len(part) >= 3]
    if sum(map(len, parts)) < FEWEST_LIKE_IT:
        return 0.0
    x, y = (
        np.concatenate([r - r.mean() for r in (rankdata(v[part]) for part in parts)])
        for v in (values, stop)
    )
    spread = float(np.sqrt(np.sum(x**2) * np.sum(y**2)))
    return float(np.sum(x * y)) / spread if spread > 0.0 else 0.0


def require_profiles(lacking: Iterable[str]) -> None:
    """Raise `AvahazardError` where paths lack the profile that their events need."""
    names = ", ".join(lacking)
    if names:
        raise no_profile(names)


def require_one_scale(events: Sequence[Event], prior: Observations | None = None) -> None:
    """Raise `AvahazardError` where there are no events, or some have H/L alone, others metres."""
    if not events:
        raise AvahazardError(
            "There are no events to work on.", "Import some: avahazard import FOLDER."
        )
    in_ratio = events[0].in_ratio
    if any(e.in_ratio != in_ratio for e in events) or (prior and prior.in_ratio != in_ratio):
        raise AvahazardError(
            "H/L alone and runouts in metres have no score in common.",
            "Give H or L with each h_over_l, or keep such events in a database of their own.",
        )


def _arranged(
    records: Records,
    prior: Observations | None,
    sites: tuple[Site, ...],
    release: Ints,
    columns: EventColumns,
) -> Observations:
    """Observations of the records' events, which start at `release` of their sites, if any."""
    events, in_ratio = records.events, records.events[0].in_ratio
    paths = {p.path_id: p for p in records.paths}
    kinds = [_observation(e) for e in events]
    kind = np.array([k for k, _ in kinds], dtype=np.int64)
    observed = np.array([v for _, v in kinds], np.float64)
    # Few events that are to be predicted may follow their stops by chance.
    outcomes = outcome_columns(columns, kind, observed) if prior is None else {}
    # Measured speeds are held against those of a block alone.
    simulated = any(isinstance(site, SimulatedSite) for site in sites)
    speeds = () if simulated else speed_records(records, columns, sites, release)
    columns = replace(
        columns,
        numbers={name: values for name, values in columns.numbers.items() if name not in outcomes},
        tracks=speeds,
    )
    fall_height = np.array([1.0 if in_ratio else e.fall_height_m or np.nan for e in events])
    of_record, of_leaving = carried_error(
        stated_release_sigma(events, paths),
        sites,
        columns.path_index,
        release,
        kind == LENGTH,
        kind == PLACE,
        observed,
        fall_height,
    )
    sigma = [
        H_OVER_L_REL_SIGMA / (e.h_over_l or 1.0) if e.in_ratio else e.runout_sigma_m for e in events
    ]
    limit = [paths[e.path_id].observed_below_m if e.path_id else None for e in events]
    return Observations(
        sites=sites,
        columns=columns,
        kind=kind,
        observed=observed,
        sigma=np.hypot(np.array(sigma), of_record),
        release_sigma=of_record,
        leaving_sigma=of_leaving,
        release=release,
        fall_height=fall_height,
        limit=np.array(limit, np.float64),
        volumes=volume_nodes(events, columns, None if prior is None else prior.volumes),
        speeds=speeds,
        in_ratio=in_ratio,
        outcomes=outcomes,
    )


def _grounds(profiles: Sequence[Profile]) -> Iterable[SmoothProfile]:
    """The profiles regularised: by other processes, if any, where they are many."""
    if len(profiles) < MANY_PATHS:
        return (_ground(None, profile) for profile in profiles)
    made = spread_map(_ground, None, profiles, threads=False)
    return (_with_points_of(*pair) for pair in zip(profiles, made, strict=True))


def _with_points_of(profile: Profile, smooth: SmoothProfile) -> SmoothProfile:
    """The same, which another process may have made, with the arrays of the profile itself."""
    if smooth.points is None:
        return smooth
    return replace(smooth, points=smooth.points._replace(x=profile.x_m, y=profile.y_m))


def _ground(_shared: None, profile: Profile) -> SmoothProfile:
    return smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)


def _observation(event: Event) -> tuple[int, float | None]:
    if event.left_profile:
        return LEFT, np.nan
    if event.path_id is None:
        if event.in_ratio:
            return LENGTH, event.h_over_l and 1.0 / event.h_over_l
        return LENGTH, event.runout_length_m
    if event.runout_x_m is not None:
        return PLACE, event.runout_x_m
    return ELEVATION, event.runout_elevation_m


def part_of(observations: Observations, events: Ints) -> Observations:
    """These `events` `[n]`, with their tracks; volumes are read in the light of all."""
    columns, volumes = observations.columns, observations.volumes
    place = {event: k for k, event in enumerate(events.tolist())}
    path = columns.path_index[events]
    known = np.unique(path[path >= 0])

    def of(record: Any, **own: Any) -> Any:
        """A dataclass with the rows of these events in all its columns."""
        every = {f.name: getattr(record, f.name) for f in fields(record) if f.init}
        rows = {k: v[events] for k, v in every.items() if isinstance(v, np.ndarray)}
        return replace(record, **rows, **own)

    part: Observations = of(
        observations,
        sites=tuple(observations.sites[k] for k in known),
        columns=replace(
            columns.at(events),
            paths=tuple(columns.paths[k] for k in known),
            path_index=np.where(path >= 0, np.searchsorted(known, path), -1),
        ),
        volumes=of(volumes, records=of(volumes.records)),
        speeds=tuple(
            replace(track, event=place[track.event])
            for track in observations.speeds
            if track.event in place
        ),
    )
    return part


def whole_paths(observations: Observations, at_once: int) -> list[Ints]:
    """Events of all paths, whole paths together, in parts of some `at_once`."""
    path = observations.columns.path_index
    order = np.argsort(path, kind="stable")
    # A part ends with the path of its last event.
    ends = np.searchsorted(path[order], path[order][at_once - 1 :: at_once], side="right")
    return [part for part in np.split(order, np.unique(ends)) if len(part)]
