"""Bounds of the runout as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

from avahazard.effects.site import release_place
from avahazard.records.collection import Records
from avahazard.records.lookup import find_path
from avahazard.workflow.alpha_beta import baseline, recorded_stops


def draw_hazard(
    file: FilePath, title: str, records: Records, rows: Sequence[dict[str, Any]]
) -> None:
    """Draw the rows of `hazard` to `file`, a panel each.

    With the recorded stops and the α-β runouts of their paths.

    Raises:
        AvahazardError: a path has no profile, or `file` is not the name of a picture.
    """
    from avahazard.report.bounds_figure import DrawnPath, draw_bounds  # noqa: PLC0415 (slow)

    drawn = []
    for row in rows:
        path = find_path(records, row["path_id"])
        smooth, both = baseline(records, path)
        events = [e for e in records.events if e.path_id == path.path_id]
        drawn.append(
            DrawnPath(
                name=path.name or path.path_id,
                smooth=smooth,
                release_x=release_place(smooth, path.release_elevation_m),
                stop_x=recorded_stops(records, path, smooth),
                n_left=sum(e.left_profile for e in events),
                row=row,
                baseline=both,
            )
        )
    draw_bounds(file, title, drawn)
