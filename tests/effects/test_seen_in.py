"""Where the records have what an effect is about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects import motion
from avahazard.effects.columns import EventColumns, build_columns
from avahazard.effects.covariate import PATH_SECTION
from avahazard.effects.site import Site, path_site
from avahazard.records.collection import Event, Path
from tests.workflow.worlds import bowl


def wooded(name: str, *, forest: bool) -> Site:
    profile = bowl().profiles[0]
    cover = tuple("forest" if forest and k % 7 == 3 else "open" for k in range(len(profile.x_m)))
    return path_site(Path(name), replace(profile, path_id=name, land_cover=cover))


def columns(paths: dict[str, str | None]) -> EventColumns:
    known = {name: Path(name, section=section) for name, section in paths.items()}
    events = [Event(f"{name}{k}", path_id=name) for name in paths for k in range(3)]
    return build_columns(events, known, np.full(len(events), np.nan))


def test_paths_with_forest_are_named() -> None:
    table = columns({"P01": None, "P02": None, "P06": None})
    sites = [wooded("P01", forest=True), wooded("P02", forest=False), wooded("P06", forest=True)]
    seen = motion.FOREST_DRAG.seen_in(table, sites)
    assert seen == "P01 and P06 have forest (6 of 9 events)."
    assert motion.FOREST_DRAG.seen_in(table, sites[1:2]) is None


def test_paths_are_named_by_their_section() -> None:
    table = columns({"A": "open", "B": "channelled", "C": "open"})
    seen = PATH_SECTION.seen_in(table, [])
    assert seen == "section differs by path: A and C: open; B: channelled."
