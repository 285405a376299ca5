"""A path made ready to run: regularised, cut into cells, with its releases, cover and runs."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.physics.block import LEFT_PROFILE, STOPPED, Asked
from avahazard.physics.cells import Cells, Resistance, build_cells
from avahazard.physics.runout_curve import (
    COARSE_MU,
    MU,
    NearStops,
    RunoutCurve,
    as_near_stops,
    near_stops,
    tabulate,
)
from avahazard.physics.smooth_profile import SmoothProfile, smooth_profile
from avahazard.physics.speed import filled_speeds, speeds_along
from avahazard.physics.terrain import MAX_CELL_M, Terrain, cell_ends, node_of, terrain_at
from avahazard.records.collection import Event, Path, Profile, Simulation


@dataclass(frozen=True, slots=True, eq=False)
class StopTable:
    """Stops (m) along a path's line, over friction for each of some volumes (m3), rising.

    `friction` `[n_volumes]` holds the frictions of each volume, rising, `stop_x` `[n_volumes]` the
    stops. `end_x` is the line's end.
    """

    volume: Floats
    friction: tuple[Floats, ...]
    stop_x: tuple[Floats, ...]
    end_x: float

    def at(self, volume: float, friction: Floats) -> Floats:
        """Stops (m) `[n_friction]` of a volume (m3), inf for what left the line.

        The friction that brings an avalanche to a place goes straight in the log of the volume, and
        straight from place to place. Beyond the table its end counts.
        """
        place = np.interp(np.log(volume), np.log(self.volume), np.arange(len(self.volume)))
        low, high = int(np.floor(place)), int(np.ceil(place))
        x = np.unique(np.concatenate([self.stop_x[low], self.stop_x[high]]))
        share = place - low
        both = (1.0 - share) * self._bringing(low, x) + share * self._bringing(high, x)
        found = np.interp(friction, both[::-1], x[::-1])
        return np.where(found >= self.end_x - 1e-6, np.inf, found)

    def _bringing(self, k: int, x: Floats) -> Floats:
        """The most friction with which volume k comes to places x (m), rising `[n]`."""
        stop, first = np.unique(self.stop_x[k][::-1], return_index=True)
        return np.asarray(np.interp(x, stop, self.friction[k][::-1][first]))


def stop_table(simulations: Sequence[Simulation], release_x: float, end_x: float) -> StopTable:
    """The table of a path's runs; what did not move stopped at `release_x` (m)."""
    rising = sorted(simulations, key=lambda s: (s.volume_m3, s.friction))
    of_volume = {v: list(runs) for v, runs in groupby(rising, key=lambda s: s.volume_m3)}
    stops = [
        np.array([release_x if np.isnan(s.stop_x_m) else min(s.stop_x_m, end_x) for s in runs])
        for runs in of_volume.values()
    ]
    friction = tuple(np.array([s.friction for s in runs]) for runs in of_volume.values())
    # More friction never carries farther: what the cells leave of it is noise.
    stop_x = tuple(np.maximum.accumulate(x[::-1])[::-1] for x in stops)
    return StopTable(np.array(list(of_volume)), friction, stop_x, end_x)


SPEED_CELL_M = 10.0
"""Cell length where friction depends on speed: the step is then of second order only."""
ALL = slice(None)
KEPT_TERRAINS = 64
"""Terrains, those asked for last, that are kept: each is 100 times as large as its nodes."""


@dataclass(frozen=True, eq=False)
class Site:
    """One path, cut at `nodes` (m), with releases `release_x` `[n_releases]` (m) among them.

    What is held of its terrains, which are large, are their nodes: the rest is made when it is
    asked for, but for those `kept`, if it `keeps` any.
    """

    path: Path
    profile: Profile
    smooth: SmoothProfile
    nodes: Floats
    release_x: Floats
    keeps: bool = True
    kept: dict[bool, Terrain] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def terrain_x(self) -> Floats:
        """The nodes of `terrain` (m)."""
        return cell_ends(self.smooth, self.nodes, MAX_CELL_M)

    @cached_property
    def fine_terrain_x(self) -> Floats:
        """The nodes of `fine_terrain` (m)."""
        return cell_ends(self.smooth, self.nodes, SPEED_CELL_M)

    @property
    def terrain(self) -> Terrain:
        """The path in cells."""
        return self.kept.get(False) or _terrain(self, fine=False)

    @property
    def fine_terrain(self) -> Terrain:
        """The path in cells for friction that depends on speed."""
        return self.kept.get(True) or _terrain(self, fine=True)

    @cached_property
    def end_y(self) -> float:
        """Elevation (m) of the end of the path."""
        return float(self.heights()[-1])

    def heights(self) -> Floats:
        """Elevations (m) of the nodes of `terrain`."""
        return self.smooth.height(self.terrain_x)

    def terrain_for(self, resistance: Resistance) -> Terrain:
        """The terrain whose number of cells fits this resistance."""
        fits = len(resistance.drag) == len(self.terrain_x) - 1
        return self.terrain if fits else self.fine_terrain

    def keep_terrain(self, resistance: Resistance) -> None:
        """Keep the terrain of this resistance as long as the site: other values ask for it too."""
        if self.keeps:
            terrain = self.terrain_for(resistance)
            self.kept[terrain is not self.terrain] = terrain

    def cover(self, x: Floats) -> NDArray[np.str_]:
        """Land cover at places (m), that of the profile point before each; `open` if unknown."""
        cover = self.profile.land_cover
        if cover is None:
            return np.full(len(x), "open")
        point = np.searchsorted(self.profile.x_m, x, side="right") - 1
        return np.asarray(cover)[np.clip(point, 0, len(cover) - 1)]

    def cells(self, resistance: Resistance) -> Cells:
        """The path in cells with this resistance."""
        return build_cells(self.terrain_for(resistance), resistance)

    def table(self, cells: Cells) -> RunoutCurve:
        """F(μ) from every release of the site, `[n_releases, n_friction]`."""
        return tabulate(cells, np.searchsorted(cells.x, self.release_x))

    def table_near(self, cells: Cells, asked: Asked) -> NearStops:
        """The same near some stops from each release alone (`near_stops`)."""
        return near_stops(cells, np.searchsorted(cells.x, self.release_x), asked)

    def speeds(self, cells: Cells, release_x: float, x: Floats, near: slice = ALL) -> Floats:
        """Speeds (m/s) at places x `[n_x]` for each friction of `MU`, `[n_friction, n_x]`.

        Of the block released at `release_x`, one of the site's. Of the frictions `near`, as
        `table_near` has them, each is run; the others have no speed.
        """
        start = node_of(cells.x, release_x)
        if cells.speed_dependent and near == ALL:
            return filled_speeds(speeds_along(cells, start, COARSE_MU, x))
        speeds = np.zeros((len(MU), len(x)))
        speeds[near] = speeds_along(cells, start, MU[near], x)
        return speeds


@dataclass(frozen=True, eq=False)
class SimulatedSite(Site):
    """A path on which a flow model has run: its stops stand in the place of the block's.

    Row k of the tables is that of an avalanche of `volume` `[n_releases]` (m3), which all start at
    one place.
    """

    volume: Floats = field(default_factory=lambda: np.empty(0))
    runs: tuple[Simulation, ...] = ()

    @cached_property
    def stops(self) -> StopTable:
        """The stops of the runs."""
        return stop_table(self.runs, float(self.release_x[0]), self.smooth.x_max)

    def table(self, cells: Cells) -> RunoutCurve:  # noqa: ARG002 (no block runs)
        """F(μ) of every volume, `[n_releases, n_friction]`."""
        x = np.array([self.stops.at(float(volume), MU) for volume in self.volume])
        left = np.isinf(x)
        x = np.where(left, np.nan, x)
        status = np.where(left, LEFT_PROFILE, STOPPED).astype(np.int8)
        return RunoutCurve(x, self.smooth.height(x), status)

    def table_near(self, cells: Cells, asked: Asked) -> NearStops:  # noqa: ARG002 (no block runs)
        """All stops."""
        return as_near_stops(self.table(cells))


@lru_cache(maxsize=KEPT_TERRAINS)
def _terrain(site: Site, *, fine: bool) -> Terrain:
    return terrain_at(site.smooth, site.fine_terrain_x if fine else site.terrain_x)


def build_site(
    path: Path,
    profile: Profile,
    smooth: SmoothProfile,
    release_x: Sequence[float],
    *,
    keeps: bool = True,
) -> Site:
    """Cut the regularised profile at the releases and where the land cover changes."""
    releases = np.unique(np.asarray(release_x, dtype=float))
    nodes = releases
    if profile.land_cover is not None:
        cover = np.asarray(profile.land_cover)
        nodes = np.append(releases, profile.x_m[1:][cover[1:] != cover[:-1]])
    return Site(path, profile, smooth, nodes, releases, keeps)


def simulated_site(
    path: Path, profile: Profile, smooth: SmoothProfile, volume: Floats, runs: Sequence[Simulation]
) -> SimulatedSite:
    """The path with the stops of a flow model's runs, for avalanches of `volume` `[n]` (m3)."""
    start = release_place(smooth, path.release_elevation_m)
    releases = np.full(len(volume), start)
    return SimulatedSite(
        path, profile, smooth, np.array([start]), releases, volume=volume, runs=tuple(runs)
    )


def path_site(path: Path, profile: Profile) -> Site:
    """Return the regularised path with one release: the path's own, else its top."""
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    return build_site(path, profile, smooth, [release_place(smooth, path.release_elevation_m)])


def release_place(smooth: SmoothProfile, elevation: float | None) -> float:
    """x (m) where a path first falls to an elevation: its top if None or above; else its lowest."""
    return release_places(smooth, [elevation])[0]


def release_places(smooth: SmoothProfile, elevations: Sequence[float | None]) -> list[float]:
    """`release_place` of each elevation."""
    x, y = smooth.sampled()
    wanted = np.array([np.inf if z is None else z for z in elevations], np.float64)
    falls = -np.minimum.accumulate(y)
    cell = np.searchsorted(falls, -wanted)
    inside = np.flatnonzero((cell > 0) & (cell < len(x)))
    low, high = x[cell[inside] - 1], x[cell[inside]]
    row = np.arange(len(inside))
    for _ in range(5):
        between = np.linspace(low, high, 101, axis=1)
        k = np.maximum(1, np.argmax(smooth.height(between) <= wanted[inside, None], axis=1))
        low, high = between[row, k - 1], between[row, k]
    found = np.where(cell > 0, x[np.argmin(y)], smooth.x_min)
    # Rounded so that a record read twice gives the same node.
    found[inside] = np.minimum(np.round(high, 6), smooth.x_max)
    return [float(place) for place in found]


def stop_places(smooth: SmoothProfile, events: Sequence[Event]) -> list[float | None]:
    """x (m) of the recorded stop of each event, None where it is beyond the profile."""
    by_elevation = release_places(smooth, [event.runout_elevation_m for event in events])
    return [
        None if event.left_profile else place if event.runout_x_m is None else event.runout_x_m
        for event, place in zip(events, by_elevation, strict=True)
    ]


def stop_place(smooth: SmoothProfile, event: Event) -> float | None:
    """x (m) of the recorded stop, None where it is beyond the profile."""
    return stop_places(smooth, [event])[0]
