"""What is recorded on each path, summed up by the database itself."""

from __future__ import annotations

from typing import Any

from sqlalchemy import case, func, select
from sqlalchemy.orm import Session

from avahazard.results.base import Rows
from avahazard.results.terrain import PathSummary
from avahazard.store.tables import EventTable, PathTable, ProfilePointTable


def path_summaries(session: Session) -> Rows[PathSummary]:
    """One entry a path, in the order in which they came; lengths in m, volumes in m3.

    None where something is not known. No record is loaded: a region has many.
    """
    profiles, events = _profiles(session), _events(session)
    rows = []
    query = select(PathTable.path_id, PathTable.name, PathTable.section).order_by(PathTable.id)
    for path_id, name, section in session.execute(query):
        n_points, top, lowest, length = profiles.get(path_id, (0, None, None, None))
        n, left, first, last, small, large = events.get(path_id, (0, 0, None, None, None, None))
        rows.append(
            PathSummary(
                path_id=path_id,
                name=name,
                section=section,
                n_points=n_points,
                top_m=top,
                drop_m=None if top is None or lowest is None else top - lowest,
                length_m=length,
                n_events=n,
                n_left_profile=int(left),
                first_year=None if first is None else int(first),
                last_year=None if last is None else int(last),
                volume_min_m3=small,
                volume_max_m3=large,
            )
        )
    return Rows(rows)


def _profiles(session: Session) -> dict[str, tuple[Any, ...]]:
    """Points, top, lowest point and length of each profile."""
    point = ProfilePointTable
    query = select(
        point.path_id,
        func.count(),
        func.max(case((point.point == 0, point.y_m))),
        func.min(point.y_m),
        func.max(point.x_m) - func.min(point.x_m),
    )
    return {row[0]: tuple(row[1:]) for row in session.execute(query.group_by(point.path_id))}


def _events(session: Session) -> dict[str, tuple[Any, ...]]:
    """Number, those that left, first and last year, smallest and largest volume by path."""
    event = EventTable
    year = func.substr(event.date, 1, 4)
    query = select(
        event.path_id,
        func.count(),
        func.sum(case((event.left_profile, 1), else_=0)),
        func.min(year),
        func.max(year),
        func.min(event.volume_m3),
        func.max(event.volume_m3),
    )
    return {row[0]: tuple(row[1:]) for row in session.execute(query.group_by(event.path_id))}
