"""Which form a file has: by its header, its name being only a hint."""

from __future__ import annotations

from pathlib import PurePath
from typing import Literal

from avahazard.records.errors import RowProblem
from avahazard.records.table import Table

Kind = Literal["paths", "profiles", "events", "velocities"]

FORMS = (
    "the columns of paths (path_id), profiles (path_id, x_m, y_m), events (event_id and path_id, "
    "or fall_height_m and runout_length_m, or h_over_l) or velocities (event_id, x_m or "
    "elevation_m, speed_m_s)"
)


def recognise(table: Table, problems: list[RowProblem], *, need_runout: bool = True) -> Kind | None:
    """Return the kind of `table`, or None after adding to `problems` what its header lacks."""
    columns = set(table.header)
    kind = _kind(columns, (table.name or PurePath(table.file).stem).lower())
    if kind is None:
        problems.append(RowProblem(table.file, 1, "", ", ".join(table.header), FORMS))
        return None
    lacking = [names for names in _required(kind, columns, need_runout) if not columns & set(names)]
    for names in lacking:
        accepted = "a column " + " or ".join(names)
        problems.append(RowProblem(table.file, 1, names[0], "", accepted))
    return None if lacking else kind


def _kind(columns: set[str], stem: str) -> Kind | None:
    if "event_id" in columns:
        speeds = "speed_m_s" in columns or stem.startswith(("velocit", "speed"))
        return "velocities" if speeds else "events"
    if "path_id" in columns:
        points = {"x_m", "y_m"} <= columns or (
            bool({"x_m", "y_m"} & columns) and not stem.startswith("path")
        )
        return "profiles" if points or stem.startswith("profile") else "paths"
    for start, kind in _BY_NAME.items():
        if stem.startswith(start):
            return kind
    return None


_BY_NAME: dict[str, Kind] = {
    "path": "paths",
    "profile": "profiles",
    "event": "events",
    "velocit": "velocities",
    "speed": "velocities",
}


def _required(kind: Kind, columns: set[str], need_runout: bool) -> list[tuple[str, ...]]:
    """Return groups of columns, of each of which one must be there."""
    if kind == "paths":
        return [("path_id",)]
    if kind == "profiles":
        return [("path_id",), ("x_m",), ("y_m",)]
    if kind == "velocities":
        return [("event_id",), ("speed_m_s",), ("x_m", "elevation_m")]
    straight = {"fall_height_m", "runout_length_m", "h_over_l"}
    if "path_id" not in columns and columns & straight:
        if "h_over_l" in columns:
            return [("event_id",)]
        heights = ("fall_height_m", "runout_elevation_m")
        return [("event_id",), heights, *([("runout_length_m",)] if need_runout else [])]
    needed: list[tuple[str, ...]] = [("event_id",), ("path_id",)]
    if need_runout:
        needed.append(("runout_x_m", "runout_elevation_m", "left_profile", *sorted(straight)))
    return needed
