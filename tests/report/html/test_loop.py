"""The loop in the report: the story, the switch, the budget, the first screen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.report.html.brief import path_cards
from avahazard.report.html.content import Cover, ForceView, ReportContent
from avahazard.report.html.page import render
from avahazard.report.html.path_figure import _moving, stops_of, stops_traces
from avahazard.report.html.record_figures import (
    failed_figure,
    force_shape_figure,
    predicted_figures,
    residuals_figure,
    suspect_figure,
)
from avahazard.report.html.score_figures import budget_figure
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart
from avahazard.results.diagnosis import Shape
from tests.report.html.pages import section_words
from tests.telling import untold


def test_the_shown_error_is_that_of_compare(loop_content: ReportContent) -> None:
    loop = loop_content.loop
    assert [state.key for state in loop.models] == ["base", "child"]
    for state in loop.models:
        scores = loop.comparisons[state.key].scores.runout
        assert state.crps_m == pytest.approx(scores.crps_m, rel=0.01)
        assert state.rmse_m == pytest.approx(scores.rmse_m, rel=0.01)
        assert state.held_out_m == loop.comparisons[state.key].held_out.runout.crps_m


def test_the_story_has_failure_evidence_fall_and_what_is_left(loop_content: ReportContent) -> None:
    text = section_words(loop_content, "loop")
    assert (
        untold(text, "Held-out CRPS", "The model lacks an effect: snow-type", "P01 has snow") == []
    )
    assert "“child”: “base” and snow-type" in text
    before, after = (
        loop_content.loop.comparisons[k].held_out.runout.crps_m for k in ("base", "child")
    )
    assert untold(text, f"from {before:.1f} m to {after:.1f} m") == []


def test_the_story_has_its_pictures(loop_content: ReportContent) -> None:
    names, loop = loop_content.names, loop_content.loop
    failed = failed_figure(loop_content.events, names, loop)
    assert failed is not None
    assert loop.before is loop.models[0]
    drawn = sum(len(trace["x"]) for trace in failed.data if trace["mode"] == "markers")
    assert drawn == sum(e.stop_x_m is not None for e in loop_content.events)
    assert loop.suspect is not None
    assert loop.suspect.effects == ("snow-type",)
    assert loop.suspect.column == "snow_type"
    assert loop.suspect.values is not None
    # The effect adds as much to every event of one kind of snow.
    by_kind: dict[str, list[float]] = {}
    for kind, added in zip(loop.suspect.values, loop.suspect.explained, strict=True):
        if np.isfinite(added):
            by_kind.setdefault(str(kind), []).append(float(added))
    assert len(by_kind) > 1
    assert all(np.ptp(added) < 1e-6 for added in by_kind.values())
    suspect = suspect_figure(loop_content.events, names, loop)
    assert suspect is not None
    assert set(suspect.data[-1]["x"]) == set(by_kind)


def test_a_force_has_its_curve_with_its_band_and_the_measured_ones(
    loop_content: ReportContent,
) -> None:
    names = {view.path.path_id: view.name for view in loop_content.paths}
    loop, events = loop_content.loop, loop_content.events
    assert loop.suspect is not None
    assert force_shape_figure(events, names, loop) is None
    x = np.linspace(0.0, 60.0, 13)
    low, middle, high = (tuple(k * x**2) for k in (0.002, 0.003, 0.004))
    shape = Shape("speed", "m/s", "force per mass, m/s2", tuple(x), low, middle, high)
    event = [e.event_id for e in events[:4]]
    there = np.array([10.0, 20.0, 30.0, 40.0])
    force = ForceView(shape, event, there, 0.003 * there**2, np.full(4, 0.1))
    found = force_shape_figure(
        events, names, replace(loop, suspect=replace(loop.suspect, force=force))
    )
    assert found is not None
    band, *marked, curve = found.data
    assert np.max(band["y"]) == high[-1]
    assert sum(len(trace["x"]) for trace in marked) == 4
    assert curve["y"] == middle
    # Drawn to a little past what was measured.
    assert 40.0 < found.layout["xaxis"]["range"][1] < 45.0
    changed = replace(loop, suspect=replace(loop.suspect, force=force))
    told = section_words(replace(loop_content, loop=changed), "loop")
    assert "a stretch of a measured track" in told
    bare = replace(force, event=[], x=np.empty(0), y=np.empty(0), sd=np.empty(0))
    changed = replace(loop, suspect=replace(loop.suspect, force=bare))
    assert "No speeds were measured" in section_words(replace(loop_content, loop=changed), "loop")


def test_states_change_the_traces_that_they_name(loop_content: ReportContent) -> None:
    names = {view.path.path_id: view.name for view in loop_content.paths}
    (predicted, *_) = predicted_figures(loop_content.events, names, loop_content.loop)
    residuals = residuals_figure(loop_content.events, names, loop_content.loop)
    assert residuals is not None
    for figure, key in ((predicted, "x"), (residuals, "y")):
        assert set(figure.states) >= {"base", "child"}
        for number, change in figure.states["child"].items():
            np.testing.assert_allclose(change[key], figure.data[number][key])
        assert any(
            not np.allclose(change[key], figure.data[number][key])
            for number, change in figure.states["base"].items()
        )


def test_records_without_a_stop_have_no_figure(loop_content: ReportContent) -> None:
    names = {str(k): str(k) for k in range(20)}  # too many for a colour each
    events = loop_content.events
    left = [replace(e, coordinate="x", observed_m=None) for e in events[:5]]
    found = predicted_figures([*left, *events[5:]], names, loop_content.loop)
    assert [figure.key for figure in found] == ["predicted-elevation"]


def test_a_path_shows_every_record_with_both_bands(loop_content: ReportContent) -> None:
    view = loop_content.paths[0]
    shown = stops_of(view, loop_content.loop, loop_content.events)
    assert len(shown) == sum(e.stop_x_m is not None for e in view.events)
    before, now, _, records = stops_traces(view, loop_content.loop, loop_content.events, shown)[0]
    assert "base" in before["name"]
    assert len(now["x"]) == 3 * len(shown)
    assert records["x"] == [loop_content.events[k].stop_x_m for k in shown]
    volumes = [loop_content.events[k].volume_m3 or 0.0 for k in shown]
    assert volumes == sorted(volumes)


def test_the_budget_is_one_bar_a_model_whose_squares_add_up(loop_content: ReportContent) -> None:
    parts = {"record": 10.0, "scatter": 30.0, "snow-type": 20.0, "unexplained": 5.0}
    budget = Rows(BudgetPart(source, rms) for source, rms in parts.items())
    known = {k: replace(c, budget=budget) for k, c in loop_content.loop.comparisons.items()}
    figure = budget_figure(loop_content.ladder, known)
    assert figure is not None
    assert [t["name"] for t in figure.data] == [
        "errors of the recorded runouts",
        "scatter, natural or missing in the model",
        "explained by snow-type",
        "unexplained",
    ]
    assert [sum(t["x"][k] for t in figure.data) for k in (0, 1)] == [1425.0, 1425.0]
    bare = {k: replace(c, budget=Rows()) for k, c in known.items()}
    assert budget_figure(loop_content.ladder, bare) is None


def test_the_brief_answers_for_every_path(loop_content: ReportContent) -> None:
    cards, _ = path_cards(loop_content)
    assert [card.view.name for card in cards] == [view.name for view in loop_content.paths]
    for card in cards:
        ((period, _, interval, _),) = card.lines
        assert period.rstrip("*") == "100"
        assert "–" in interval


def test_the_cover_leads_the_page(loop_content: ReportContent) -> None:
    cover = Cover("Val <d'Arly>", "A. Favre", "Megève", "2026-01-31")
    text = render(replace(loop_content, cover=cover))
    assert "<h1>Val &lt;d&#39;Arly&gt;</h1>" in text
    assert "<title>Val &lt;d" in text
    assert untold(text, "A. Favre, 2026‑01‑31", "· Megève") == []
    assert len(text) < 10e6


def test_speeds_are_drawn_up_to_the_last_place_that_is_reached() -> None:
    """A part of the avalanches starts below the first places."""
    assert _moving([0.0, 0.0, 5.0, 9.0, 0.0, 0.0]) == [0.0, 0.0, 5.0, 9.0, 0.0, None]
