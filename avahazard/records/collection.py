"""Paths, avalanches, speeds and runs of flow models as records, and all that belong together."""

import hashlib
import json
import sqlite3
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any
from unicodedata import normalize

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.notes import ENGLISH
from avahazard.records.errors import AvahazardError, did_you_mean

Covariate = float | str
DEGREES = "EPSG:4326"
"""The system of longitude and latitude."""


@dataclass(frozen=True, slots=True)
class Path:
    """What is known of a path apart from its profile (docs/data_forms.md)."""

    path_id: str
    name: str | None = None
    location: str | None = None
    orientation: str | None = None
    section: str | None = None
    catchment_ha: float | None = None
    release_elevation_m: float | None = None
    observed_from: int | None = None
    observed_to: int | None = None
    observed_below_m: float | None = None
    covariates: Mapping[str, Covariate] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """Points along a path: `x_m` rises strictly from the top, all arrays `[n_points]`.

    `elevation_sigma_m` is the error of each elevation, one standard deviation, None where it is not
    known. Coordinates are either `easting_m`, `northing_m` in `crs`, or `lon`, `lat`, or absent.
    """

    path_id: str
    x_m: Floats
    y_m: Floats
    land_cover: tuple[str, ...] | None = None
    easting_m: Floats | None = None
    northing_m: Floats | None = None
    crs: str | None = None
    lon: Floats | None = None
    lat: Floats | None = None
    elevation_sigma_m: Floats | None = None

    @property
    def on_map(self) -> tuple[Floats, str] | None:
        """Its points on the map `[n_points, 2]`, to the east and north, and their system.

        In metres where that is named, else in degrees; empty for metres of no named system. None
        without coordinates.
        """
        degrees = self.lon is not None and self.lat is not None
        if self.easting_m is not None and self.northing_m is not None and (self.crs or not degrees):
            return np.column_stack([self.easting_m, self.northing_m]), self.crs or ""
        if self.lon is not None and self.lat is not None:
            return np.column_stack([self.lon, self.lat]), DEGREES
        return None


NUMBERS_OF_POINTS = ("x_m", "y_m", "easting_m", "northing_m", "lon", "lat", "elevation_sigma_m")
"""The arrays of a profile."""


@dataclass(frozen=True, slots=True, eq=False)
class TerrainCrop:
    """Elevations `elevation_m` `[n_rows, n_columns]` float32, NaN where they are not known.

    Rows run from north to south, columns from west to east; the cells are squares of `cell_m`
    in `crs` (such as `EPSG:31287`), and `west_m`, `north_m` is the outer corner of the first.
    """

    path_id: str
    crs: str
    west_m: float
    north_m: float
    cell_m: float
    elevation_m: NDArray[np.float32]


WINTER_STARTS = 10
"""Month in which a winter begins: it lasts from October to September."""


@dataclass(frozen=True, slots=True)
class Event:
    """One recorded avalanche, complete: defaults are filled in when it is read.

    Either `path_id` is set and the stop is `runout_x_m` or `runout_elevation_m` (both
    None only when `left_profile`), or `fall_height_m` and `runout_length_m` are set, or
    `h_over_l` alone, and there is no profile. `date` is ISO text, `YYYY` or `YYYY-MM-DD`.
    `release_elevation_m` None means the path's own, else the top of its profile.
    `runout_sigma_m` is the standard deviation of the record in the coordinate that was recorded
    (not of H/L alone); `volume_rel_sigma` that of log volume.
    """

    event_id: str
    path_id: str | None = None
    date: str | None = None
    runout_elevation_m: float | None = None
    runout_x_m: float | None = None
    runout_sigma_m: float = 10.0
    left_profile: bool = False
    release_elevation_m: float | None = None
    volume_m3: float | None = None
    deposit_length_m: float | None = None
    deposit_width_m: float | None = None
    deposit_thickness_m: float | None = None
    volume_rel_sigma: float = 0.5
    fall_height_m: float | None = None
    runout_length_m: float | None = None
    h_over_l: float | None = None
    covariates: Mapping[str, Covariate] = field(default_factory=dict)

    @property
    def in_ratio(self) -> bool:
        """Whether H/L alone is recorded of its stop."""
        return self.path_id is None and self.fall_height_m is None

    @property
    def deposit_m3(self) -> float | None:
        """Volume of its deposit, V = L W H / 2 (paper, section 2); None where a side is unknown."""
        length, width = self.deposit_length_m, self.deposit_width_m
        if length is None or width is None or self.deposit_thickness_m is None:
            return None
        return length * width * self.deposit_thickness_m / 2.0

    @property
    def year(self) -> int | None:
        """Calendar year of the event, None without a date."""
        return int(self.date[:4]) if self.date else None

    def winter(self) -> int | None:
        """The year in which its winter ends, that of a date with a year alone; None without one."""
        if self.date is None:
            return None
        month = int(self.date[5:7]) if len(self.date) >= 7 else 1
        return int(self.date[:4]) + (month >= WINTER_STARTS)


@dataclass(frozen=True, slots=True)
class Speed:
    """One measured speed; exactly one of `x_m`, `elevation_m` is set."""

    event_id: str
    speed_m_s: float
    speed_sigma_m_s: float
    x_m: float | None = None
    elevation_m: float | None = None


H_OVER_L_REL_SIGMA = 0.05
"""Error of an H/L that is recorded alone, as a share of it: tables give two digits."""


def runout_sigma_m(year: int | None) -> float:
    """Standard deviation (m) of a runout: 25 before 1905, linear to 10 in 1975; no year: 10."""
    if year is None or year >= 1975:
        return 10.0
    if year < 1905:
        return 25.0
    return 25.0 - 15.0 * (year - 1905) / 70.0


def speed_sigma_m_s(speed_m_s: float) -> float:
    """Standard deviation of a measured speed in m/s: a tenth of it, at least 1."""
    return max(1.0, 0.1 * speed_m_s)


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


@dataclass(frozen=True, slots=True)
class Records:
    """All records in order; runs are without peaks; `kept` is for what is made of them once."""

    paths: tuple[Path, ...] = ()
    profiles: tuple[Profile, ...] = ()
    events: tuple[Event, ...] = ()
    speeds: tuple[Speed, ...] = ()
    simulations: tuple[Simulation, ...] = ()
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False, compare=False)


def find_path(records: Records, path_id: str) -> Path:
    """Return the path of this name. Raises `AvahazardError` where there is none."""
    same = (path_id, normalize("NFC", path_id))
    for path in records.paths:
        if path.path_id in same:
            return path
    raise unknown_path(path_id, [path.path_id for path in records.paths])


def unknown_path(path_id: str, names: Sequence[str]) -> AvahazardError:
    """That there is no path of this name among those that there are."""
    if not names:
        hint = "There are no paths yet: import some with `avahazard import`."
    else:
        hint = f"{did_you_mean(path_id, names)}The paths are: {ENGLISH.few(names, 12)}."
    return AvahazardError(f"There is no path '{path_id}'.", hint)


def find_profile(records: Records, path: Path) -> Profile:
    """Return the profile of a path. Raises `AvahazardError` where none is stored."""
    for profile in records.profiles:
        if profile.path_id == path.path_id:
            return profile
    raise no_profile(path.path_id)


def no_profile(path_id: str) -> AvahazardError:
    """That a path has no profile."""
    return AvahazardError(
        f"No profile is stored for path {path_id}.",
        "Import a profiles.csv with the points of this path.",
    )


def no_profiles() -> AvahazardError:
    """That no path has a profile, as where H and L of events are all that is known."""
    return AvahazardError(
        "No path has a profile, so no design runout is possible.",
        "Import paths.csv, profiles.csv and their events. With H and L (or H/L) alone, `avahazard "
        "predict` gives the runouts of events and scores them.",
    )


def of_path(records: Records, path_id: str) -> Records:
    """A path with its profile and its events, without speeds; nothing of an unknown path."""
    if "by_path" not in records.kept:
        paths = {path.path_id: (path,) for path in records.paths}
        profiles = {profile.path_id: (profile,) for profile in records.profiles}
        events: dict[str | None, list[Event]] = {}
        for event in records.events:
            events.setdefault(event.path_id, []).append(event)
        records.kept["by_path"] = (paths, profiles, events)
    paths, profiles, events = records.kept["by_path"]
    return Records(
        paths.get(path_id, ()), profiles.get(path_id, ()), tuple(events.get(path_id, ()))
    )


def only_paths(records: Records, paths: Sequence[str]) -> Records:
    """The records of these paths, or of all; refused where one is unknown, or none has events."""
    if not paths:
        return records
    wanted = {find_path(records, path_id).path_id for path_id in paths}
    events = tuple(e for e in records.events if e.path_id in wanted)
    if not events:
        raise AvahazardError(
            f"There are no events on {', '.join(paths)}.", "Import some: avahazard import FOLDER."
        )
    names = {e.event_id for e in events}
    return Records(
        tuple(p for p in records.paths if p.path_id in wanted),
        tuple(p for p in records.profiles if p.path_id in wanted),
        events,
        tuple(s for s in records.speeds if s.event_id in names),
        tuple(s for s in records.simulations if s.path_id in wanted),
    )


def paths_to_run(
    path_ids: Sequence[str], with_profile: Collection[str], named: Sequence[str]
) -> list[str]:
    """The paths named, or all with a profile, by name; refused where unknown or without one."""
    known = set(path_ids)
    for path_id in named:
        if path_id not in known:
            raise unknown_path(path_id, path_ids)
        if path_id not in with_profile:
            raise no_profile(path_id)
    found = sorted(set(named) or known.intersection(with_profile))
    if not found:
        raise no_profiles()
    return found


KINDS = ("paths", "profiles", "events", "speeds")
_COLUMNS = {kind: [f.name for f in fields(kind)] for kind in (Path, Profile, Event, Speed)}
_AS_TEXT = json.JSONEncoder(sort_keys=True)


def data_fingerprint(records: Records) -> str:
    """Return the SHA-256 of `records` in hexadecimal (`Fingerprint`)."""
    if "fingerprint" not in records.kept:
        whole = Fingerprint()
        whole.add(records)
        records.kept["fingerprint"] = whole.hexdigest()
    return str(records.kept["fingerprint"])


class Fingerprint:
    """The fingerprint of records that are added piece by piece, in any order.

    It depends on what is recorded only, to the last bit of every number, not on the order
    of the records: the same data imported in another order have the same fingerprint. Lines wait
    in a temporary database, which goes to the disk where it is large, and sorts them.
    """

    def __init__(self) -> None:
        self._lines = sqlite3.connect("")
        self._lines.execute("CREATE TABLE line (kind TEXT, text TEXT)")

    def add(self, records: Records) -> bytes:
        """Add a piece, and return its own digest, which depends on the order in it."""
        own = hashlib.sha256()
        for kind in KINDS:
            for record in getattr(records, kind):
                text = _line(record)
                own.update(f"{kind} {text}\n".encode())
                self._lines.execute("INSERT INTO line VALUES (?, ?)", (kind, text))
        return own.digest()

    def hexdigest(self) -> str:
        """The fingerprint of all pieces."""
        digest = hashlib.sha256()
        for kind in KINDS:
            of_kind = "FROM line WHERE kind = ?"
            (n,) = self._lines.execute(f"SELECT count(*) {of_kind}", (kind,)).fetchone()
            digest.update(f"{kind} {n}\n".encode())
            for (text,) in self._lines.execute(f"SELECT text {of_kind} ORDER BY text", (kind,)):
                digest.update(f"{text}\n".encode())
        return digest.hexdigest()


def _line(record: Path | Profile | Event | Speed) -> str:
    # Not `asdict`, which copies all that is in it.
    values = {name: getattr(record, name) for name in _COLUMNS[type(record)]}
    # Records from before this column was have the fingerprint that they had.
    if values.get("h_over_l", 0.0) is None:
        del values["h_over_l"]
    return _AS_TEXT.encode(_exact(values))


def _exact(value: object) -> object:
    """Write every number as a hexadecimal float, and 0 for -0, which a database does not keep."""
    if isinstance(value, float):
        return (value + 0.0).hex()
    if isinstance(value, dict):
        # Most of what there is are words and gaps.
        return {
            key: item if item is None or type(item) is str else _exact(item)
            for key, item in value.items()
        }
    if isinstance(value, np.ndarray):
        return [*map(float.hex, (value + 0.0).tolist())]
    return value
