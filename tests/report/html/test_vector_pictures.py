"""Pictures of the brief."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from avahazard.report.html.content import PlanView, ReportContent
from avahazard.report.html.vector_pictures import overview_map


def test_the_overview_shows_all_paths_of_one_system(content: ReportContent) -> None:
    assert overview_map(content, 100.0) is None  # two systems
    plan = PlanView(np.array([0.0, 2000.0]), np.array([6.0, 6.01]), np.array([45.0, 45.02]), None)
    views = tuple(replace(view, plan=plan) for view in content.paths)
    drawn = overview_map(replace(content, paths=views), 100.0)
    assert drawn is not None
    assert drawn.count("<polyline") >= len(views)
    assert "<script" not in drawn
    assert " m</text>" in drawn


def test_names_on_the_map_part_where_paths_lie_side_by_side(content: ReportContent) -> None:
    def plan(k: int) -> PlanView:
        x, east = np.array([0.0, 2000.0]), 2.6e6 + 100.0 * k
        return PlanView(x, np.array([east, east]), np.array([1.182e6, 1.18e6]), "EPSG:2056")

    views = tuple(replace(view, plan=plan(k)) for k, view in enumerate(content.paths))
    drawn = overview_map(replace(content, paths=views), None)
    places = re.findall(r'<text x="(-?\d+)" y="(-?\d+)">([^<]+)', str(drawn))[: len(views)]
    assert len(places) == len(views) > 1
    for k, (x, y, name) in enumerate(places):
        for a, b, _ in places[:k]:
            assert abs(int(y) - int(b)) >= 16 or abs(int(x) - int(a)) >= 6 * len(name)
