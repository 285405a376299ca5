"""Checked rows made into records, their defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from sys import intern

import numpy as np

from avahazard.arrays import Floats
from avahazard.records import defaults
from avahazard.records.errors import RowProblem
from avahazard.records.event import Event, Speed
from avahazard.records.forms.event import EventRow
from avahazard.records.forms.path import PathRow
from avahazard.records.forms.profile import ProfileRow
from avahazard.records.forms.straight import StraightRow
from avahazard.records.forms.velocity import VelocityRow
from avahazard.records.path import Covariate, Path, Profile

MIN_POINTS = 5


def build_path(row: PathRow, covariates: Mapping[str, Covariate]) -> Path:
    """Make a path of its row."""
    return Path(**row.model_dump(), covariates=covariates)


def build_event(row: EventRow | StraightRow, covariates: Mapping[str, Covariate]) -> Event:
    """Make an event of its row: default errors, and the volume of its deposit."""
    values = row.__dict__.copy()  # the model's own iteration takes four times as long
    sides = (row.deposit_length_m, row.deposit_width_m, row.deposit_thickness_m)
    if row.volume_m3 is None and None not in sides:
        values["volume_m3"] = defaults.deposit_volume_m3(*(s for s in sides if s is not None))
    if row.runout_sigma_m is None:
        values["runout_sigma_m"] = defaults.runout_sigma_m(
            int(row.date[:4]) if row.date is not None else None
        )
    if row.volume_rel_sigma is None:
        values["volume_rel_sigma"] = defaults.VOLUME_REL_SIGMA
    if isinstance(row, StraightRow):
        values["fall_height_m"], values["runout_length_m"] = row.height_and_reach
        if values["fall_height_m"] is not None:
            values["h_over_l"] = None
        values["runout_elevation_m"] = None
    values["left_profile"] = isinstance(row, EventRow) and row.left_profile
    return Event(**values, covariates=covariates)


def build_speed(row: VelocityRow) -> Speed:
    """Make a speed of its row; where both are given the distance decides, not the elevation."""
    sigma = row.speed_sigma_m_s
    return Speed(
        event_id=row.event_id,
        speed_m_s=row.speed_m_s,
        speed_sigma_m_s=defaults.speed_sigma_m_s(row.speed_m_s) if sigma is None else sigma,
        x_m=row.x_m,
        elevation_m=row.elevation_m if row.x_m is None else None,
    )


def build_profile(
    file: str, points: Sequence[tuple[int, ProfileRow]], problems: list[RowProblem]
) -> Profile | None:
    """Make a profile of its rows `(line, row)`; None after adding to `problems` what is wrong."""
    before = len(problems)
    line, first = points[0]
    if len(points) < MIN_POINTS:
        problems.append(
            RowProblem(file, line, "path_id", first.path_id, f"at least {MIN_POINTS} points a path")
        )
    for (_, left), (line, right) in pairwise(points):
        if right.x_m <= left.x_m:
            accepted = f"more than {left.x_m:g}, the x_m of the point before it"
            problems.append(RowProblem(file, line, "x_m", f"{right.x_m:g}", accepted))
    line, last = points[-1]
    if len(problems) == before and last.y_m >= first.y_m:
        accepted = f"less than {first.y_m:g}, because x_m runs from the top of the path"
        problems.append(RowProblem(file, line, "y_m", f"{last.y_m:g}", accepted))
    for name in ("land_cover", "easting_m", "lon", "elevation_sigma_m"):
        _all_or_none(file, points, name, problems)
    for line, row in points:
        if row.crs != first.crs:
            accepted = f"{first.crs or 'empty'}, as at the first point of the path"
            problems.append(RowProblem(file, line, "crs", row.crs or "", accepted))
    if len(problems) > before:
        return None
    rows = [row for _, row in points]
    cover = tuple(intern(row.land_cover) for row in rows if row.land_cover is not None)
    return Profile(
        path_id=first.path_id,
        x_m=np.array([row.x_m for row in rows]),
        y_m=np.array([row.y_m for row in rows]),
        land_cover=cover or None,
        easting_m=_optional([row.easting_m for row in rows]),
        northing_m=_optional([row.northing_m for row in rows]),
        crs=first.crs,
        lon=_optional([row.lon for row in rows]),
        lat=_optional([row.lat for row in rows]),
        elevation_sigma_m=_optional([row.elevation_sigma_m for row in rows]),
    )


def _all_or_none(
    file: str, points: Sequence[tuple[int, ProfileRow]], name: str, problems: list[RowProblem]
) -> None:
    empty = [line for line, row in points if getattr(row, name) is None]
    if len(empty) < len(points):
        for line in empty:
            accepted = f"a {name} at every point of the path, or at none"
            problems.append(RowProblem(file, line, name, "", accepted))


def _optional(values: list[float | None]) -> Floats | None:
    return None if None in values else np.array(values, dtype=np.float64)
