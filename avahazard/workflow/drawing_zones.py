"""Zones as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Records
from avahazard.records.lookup import find_path, find_profile


def draw_zone_entries(
    file: FilePath, title: str, records: Records, entries: Sequence[dict[str, Any]]
) -> None:
    """Draw the entries of `zones` to `file`, a panel each.

    Raises:
        AvahazardError: a path has no profile, or `file` is not the name of a picture.
    """
    from avahazard.report.zones_figure import ZonedPath, draw_zones  # noqa: PLC0415 (slow)

    drawn = []
    for entry in entries:
        path = find_path(records, entry["path_id"])
        profile = find_profile(records, path)
        smooth = smooth_profile(profile.x_m, profile.y_m)
        drawn.append(ZonedPath(path.name or path.path_id, smooth, entry))
    draw_zones(file, title, drawn)
