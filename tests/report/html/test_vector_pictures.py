"""Pictures of the brief."""

from __future__ import annotations

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
