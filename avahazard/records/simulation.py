"""Runs of a flow model on the ground around a path, and the stops that they give along its line."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.records.path import Path, Profile, TerrainCrop


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """A run of `engine` on a path for one friction and volume.

    `drag_per_m` (1/m) is that of a resistance by the square of speed, 0 for friction alone.
    `stop_x_m` is the farthest place that it came to along the line: the line's end where it
    `left_profile`, nan where nothing moved. `ground` names the terrain and the line (`ground_of`).
    `peak_kpa` `[n_rows, n_columns]` is the peak pressure in the cells of the path's terrain, None
    where it was not loaded.
    """

    path_id: str
    engine: str
    ground: str
    friction: float
    volume_m3: float
    drag_per_m: float
    stop_x_m: float
    left_profile: bool
    seconds: float
    peak_kpa: NDArray[np.float32] | None = None


def ground_of(path: Path, profile: Profile, crop: TerrainCrop) -> str:
    """A digest of what runs on a path stand on: terrain, line, release, and width of the flow."""
    digest = hashlib.sha256(crop.elevation_m.tobytes())
    for line in (profile.x_m, profile.easting_m, profile.northing_m, profile.lon, profile.lat):
        digest.update(b"-" if line is None else np.asarray(line, "<f8").tobytes())
    place = crop.crs, crop.west_m, crop.north_m, crop.cell_m
    digest.update(repr((place, path.release_elevation_m, path.covariates.get("width_m"))).encode())
    return digest.hexdigest()


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
    of_volume: dict[float, list[Simulation]] = {}
    for one in sorted(simulations, key=lambda s: (s.volume_m3, s.friction)):
        of_volume.setdefault(one.volume_m3, []).append(one)
    stops = [
        np.array([release_x if np.isnan(s.stop_x_m) else min(s.stop_x_m, end_x) for s in runs])
        for runs in of_volume.values()
    ]
    return StopTable(
        np.array(list(of_volume)),
        tuple(np.array([s.friction for s in runs]) for runs in of_volume.values()),
        # More friction never carries farther: what the cells leave of it is noise.
        tuple(np.maximum.accumulate(x[::-1])[::-1] for x in stops),
        end_x,
    )
