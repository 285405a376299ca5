"""The layers of a map: the paths that can be drawn, and the latest bounds and zones on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from avahazard.effects.site import release_place, stop_place
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path, Profile

if TYPE_CHECKING:
    from avahazard.gis.hazard_map import MapLayer, MappedPath, PathLine

Rows = Sequence[Mapping[str, Any]]


def map_layers(records: Records, rows: Rows, zones: Rows) -> tuple[list[MapLayer], list[str]]:
    """The layers, and notes on what has no place on them; `rows` and `zones` are documents.

    Raises `AvahazardError` where no path has coordinates.
    """
    from avahazard.gis import require_packages  # noqa: PLC0415 (may be missing)

    require_packages()
    from avahazard.gis.hazard_map import hazard_layers, path_line  # noqa: PLC0415

    profiles = {profile.path_id: profile for profile in records.profiles}
    drawn: list[MappedPath] = []
    lacking: dict[str, list[str]] = {}
    for path in records.paths:
        profile = profiles.get(path.path_id)
        line = "no profile" if profile is None else path_line(profile)
        if isinstance(line, str) or profile is None:
            lacking.setdefault(str(line), []).append(path.path_id)
        else:
            drawn.append(_drawn(records, path, profile, line))
    reasons = [f"{', '.join(paths)}: {reason}" for reason, paths in lacking.items()]
    if not drawn:
        raise AvahazardError(
            f"No path can be drawn on a map ({'; '.join(reasons) or 'there are none'}).",
            "Give profiles.csv easting_m, northing_m and crs, or lon and lat, and import it with "
            "--update; or import the paths as lines with --dem. A .csv needs no coordinates.",
        )
    notes = [f"not on the map are {reason}" for reason in reasons]
    return hazard_layers(drawn, rows, zones), notes + _notes(drawn, rows, zones)


def _drawn(records: Records, path: Path, profile: Profile, line: PathLine) -> MappedPath:
    from avahazard.gis.hazard_map import MappedPath  # noqa: PLC0415

    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    events = [event for event in records.events if event.path_id == path.path_id]
    stops = [(event, x) for event in events if (x := stop_place(smooth, event)) is not None]
    return MappedPath(path, line, release_place(smooth, path.release_elevation_m), tuple(stops))


def _notes(drawn: Sequence[MappedPath], rows: Rows, zones: Rows) -> list[str]:
    """What has no place on the map."""
    from avahazard.gis.hazard_map import QUANTILES  # noqa: PLC0415 (may be missing)

    shown = {one.path.path_id for one in drawn}
    beyond = [
        row["path_id"]
        for row in rows
        for found in (row, row.get("design"))
        if found and row["path_id"] in shown
        for quantile in QUANTILES
        if found["runout_x_m"][quantile] is None
    ]
    notes = []
    if beyond:
        notes.append(
            f"{len(beyond)} quantiles of runouts lie past the end of the profile and have no "
            f"point: {', '.join(dict.fromkeys(beyond))}. Longer profiles would tell."
        )
    bare = [
        one.path.path_id
        for one in drawn
        if one.width_m is None and any(z["path_id"] == one.path.path_id for z in zones)
    ]
    if bare:
        notes.append(f"zones as lines only, for want of a column width_m: {', '.join(bare)}.")
    return notes
