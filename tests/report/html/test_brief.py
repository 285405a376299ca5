"""The brief, and its pictures."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.notes import Note
from avahazard.report.html.brief import overview_map, path_cards, shown_period
from avahazard.report.html.content import PlanView, ReportContent
from avahazard.results.base import Rows
from avahazard.results.comparison import Failure
from tests.report.html.pages import section_words
from tests.report.html.world import NAMES
from tests.telling import untold

FAILS = Rows([Failure("path", Note.ready("scey"), 9, -50.0, 0.001)])


def concluded(content: ReportContent, **change: Any) -> str:
    return section_words(replace(content, brief=True, **change), "brief")


def test_the_conclusion_is_how_far_how_sure_and_what_lacks(content: ReportContent) -> None:
    checks = replace(content.model.diagnostics, converged=True)
    model = replace(content.model, diagnostics=checks)
    assert content.comparison is not None
    # The error along the path is that of what the design runouts are given in.
    held = content.comparison.held_out.runout_x
    assert held is not None
    text = concluded(content, model=model)
    assert (
        untold(text, f"{shown_period(content):g}-year", "2 paths", f"{held.crps_m:.0f} m of") == []
    )
    assert "lacks an effect" in text
    assert "was not diagnosed" in concluded(content, model=model, diagnosis=None)
    assert "have changed" in concluded(content, model=model, records_changed=True)
    adequate = replace(content.diagnosis, verdict="adequate", missing=(), detectable_share=0.1)
    fails = replace(content.comparison, where_it_fails=FAILS)
    text = concluded(content, model=model, diagnosis=adequate, comparison=fails)
    assert untold(text, "with 80 % power", "Yet it fails beyond chance", "50 m too low") == []
    unsure = replace(model, diagnostics=replace(checks, converged=False))
    assert "provisional" in concluded(content, model=unsure)
    assert "never compared" in concluded(content, comparison=None)
    assert "No design runout" in concluded(content, rows=())


def test_limits_hold_what_the_design_runouts_rest_on(content: ReportContent) -> None:
    rows = [row for row in content.rows if row.design]
    rising = Note("rising_friction", share=0.15, smallest=1e3, largest=1e5)
    beyond = Note("part_beyond", period=100.0)
    noted = [replace(row, notes=(rising, beyond)) for row in rows]
    text = concluded(content, rows=noted)
    assert "In 15 % of the draws larger avalanches stop earlier" in text
    assert "part of the interval" not in text
    assert ("too high, and zones too long" in concluded(content, speed_limited=False)) == any(
        view.drawn_zones for view in content.paths
    )


def test_every_path_has_its_card(content: ReportContent) -> None:
    found, common = path_cards(content)
    cards = {card.view.name: card for card in found}
    assert list(cards) == [view.name for view in content.paths]
    card = cards[NAMES["scey"]]
    assert [line[0].rstrip("*") for line in card.lines][:2] == ["30", "300"]
    assert card.shown is not None
    assert card.shown.farthest_record is not None
    assert "extrapolation" in " ".join((*card.mind, *common))
    assert "No design runout" in " ".join(cards[NAMES["saugy"]].mind)
    never = replace(content, rows=(), paths=[replace(view, rows=()) for view in content.paths])
    assert not any("No design runout" in " ".join(card.mind) for card in path_cards(never)[0])
    assert content.comparison is not None
    worse = replace(content, comparison=replace(content.comparison, where_it_fails=FAILS))
    (shown,) = [c for c in path_cards(worse)[0] if c.view.name == NAMES["scey"]]
    assert "The model fails here: bias −50 m" in " ".join(shown.mind)


def test_the_baseline_is_minded_where_it_parts_from_the_answer(content: ReportContent) -> None:
    view = next(v for v in content.paths if v.rows and v.alpha_beta)
    period = shown_period(content)
    design = next(r.design for r in view.rows if r.return_period_years == period)
    assert design is not None
    x = design.runout_x_m

    def said(place: float | None, low: float | None, high: float | None) -> str:
        runout = {"runout_x_m": place, "runout_x_low_m": low, "runout_x_high_m": high}
        changed = replace(view, alpha_beta=[replace(view.alpha_beta[0], **runout)])
        ((card,), _) = path_cards(replace(content, paths=(changed,)))
        return " ".join(card.mind)

    assert "α-β" not in said(x.q50, x.q05, x.q95)
    assert "is shorter: 1 m" in said(1.0, 1.0, 1.0)
    if x.q95 is not None:
        assert "is longer" in said(*[x.q95 + 1e5] * 3)


def test_it_says_what_it_rests_on(content: ReportContent) -> None:
    text = concluded(content)
    assert untold(text, "61 events", "extrapolated") == []
    few = replace(content.paths[0], events=())
    assert "fewer than 5" in concluded(content, paths=(few, *content.paths[1:]))
    assert "one block on one line" in text


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
