"""The rows of `hazard` as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath

from avahazard.effects.site import recorded_stops, release_place
from avahazard.hazard.alpha_beta import REGRESSIONS, alpha_beta
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Records
from avahazard.report.bounds_figure import DrawnPath, draw_bounds
from avahazard.results.hazard import HazardRow


def draw_hazard(file: FilePath, title: str, records: Records, rows: Sequence[HazardRow]) -> None:
    """Draw the rows of `hazard` to `file`, a panel each.

    The recorded stops and the α-β runouts of their paths are shown beside them.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    paths = {path.path_id: path for path in records.paths}
    smooth = {
        p.path_id: smooth_profile(p.x_m, p.y_m, p.elevation_sigma_m) for p in records.profiles
    }
    drawn = []
    for row in rows:
        path, ground = paths[row.path_id], smooth[row.path_id]
        release_x = release_place(ground, path.release_elevation_m)
        events = [e for e in records.events if e.path_id == path.path_id]
        drawn.append(
            DrawnPath(
                name=path.name or path.path_id,
                smooth=ground,
                release_x=release_x,
                stop_x=recorded_stops(ground, events),
                n_left=sum(e.left_profile for e in events),
                row=row,
                baseline=tuple(alpha_beta(ground, release_x, by) for by in REGRESSIONS),
            )
        )
    draw_bounds(file, title, drawn)
