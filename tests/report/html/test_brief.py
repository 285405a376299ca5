"""What the brief says, and what the annex says in sentences."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from avahazard.notes import Note
from avahazard.report.html.brief import (
    assumptions,
    conclusion,
    every_note,
    limits,
    notes_of,
    overview_map,
    path_cards,
    reading_words,
    rests_on,
    shown_period,
    unknown_words,
)
from avahazard.report.html.content import PlanView, ReportContent
from avahazard.results.base import Rows
from avahazard.results.comparison import Failure
from tests.report.html.world import NAMES
from tests.telling import untold


def concluded(content: ReportContent, **change: Any) -> str:
    found = conclusion(replace(content, **change))
    assert len(found) == 3
    return " ".join(found)


def test_the_conclusion_is_how_far_how_sure_and_what_lacks(content: ReportContent) -> None:
    checks = replace(content.model.diagnostics, converged=True)
    model = replace(content.model, diagnostics=checks)
    assert content.comparison is not None
    held = content.comparison.held_out.runout
    text = concluded(content, model=model)
    assert (
        untold(text, f"{shown_period(content):g}-year", "2 paths", f"{held.crps_m:.0f} m of") == []
    )
    assert "lacks an effect" in text
    assert "was not diagnosed" in concluded(content, model=model, diagnosis=None)
    assert "have changed" in concluded(content, model=model, records_changed=True)
    unsure = replace(model, diagnostics=replace(checks, converged=False))
    assert "provisional" in concluded(content, model=unsure)
    assert "never compared" in concluded(content, comparison=None)
    assert "No design runout" in concluded(content, rows=())


def test_every_path_has_its_card(content: ReportContent) -> None:
    found, common = path_cards(content)
    cards = {card.name: card for card in found}
    assert list(cards) == [view.name for view in content.paths]
    card = cards[NAMES["scey"]]
    assert [line[0].rstrip("*") for line in card.lines][:2] == ["30", "300"]
    assert str(card.picture).startswith("<svg")
    assert card.farthest is not None
    assert "extrapolation" in " ".join((*card.mind, *common))
    assert "No design runout" in " ".join(cards[NAMES["saugy"]].mind)
    assert content.comparison is not None
    fails = Rows([Failure("path", Note.ready("scey"), 9, -50.0, 0.001)])
    worse = replace(content, comparison=replace(content.comparison, where_it_fails=fails))
    (shown,) = [c for c in path_cards(worse)[0] if c.name == NAMES["scey"]]
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


def test_the_overview_shows_all_paths_of_one_system(content: ReportContent) -> None:
    assert overview_map(content) is None  # two systems
    plan = PlanView(np.array([0.0, 2000.0]), np.array([6.0, 6.01]), np.array([45.0, 45.02]), None)
    views = tuple(replace(view, plan=plan) for view in content.paths)
    drawn = overview_map(replace(content, paths=views))
    assert drawn is not None
    assert drawn.count("<polyline") >= len(views)
    assert "<script" not in drawn
    assert " m</text>" in drawn


def test_it_says_what_it_rests_on(content: ReportContent) -> None:
    text = " ".join(rests_on(content))
    assert untold(text, "61 events", "extrapolated") == []
    few = replace(content.paths[0], events=())
    assert "fewer than 5" in " ".join(rests_on(replace(content, paths=(few, *content.paths[1:]))))
    assert len(limits(content)) == 5


def test_notes_are_a_line_each_kind_and_every_one_is_there(content: ReportContent) -> None:
    row = content.rows[0]
    name = NAMES[row.path_id]
    stale, unconverged = Note("stale", model="m"), Note("unconverged", model="m")
    twice = Note("recorded_twice", "e1 = e2")
    own = (Note("extrapolated", period=500.0), Note.ready("as it was said before."))
    noted = replace(row, notes=(*own, stale, unconverged, twice))
    changed = replace(content, rows=[noted], of_model=(twice,))
    text = " ".join(notes_of(changed))
    assert f"{name}: 500 years are over twice the observed years" in text
    assert f"{name}: as it was said before." in text
    assert "since m was calibrated" not in text  # the brief says it, of the model as it is now
    assert "chains of m" not in text
    assert text.count("e1 = e2: alike in path, day and stop") == 1
    both = [
        replace(row, path_id="scey", notes=own[:1]),
        replace(row, path_id="nants", notes=own[:1]),
    ]
    several = replace(content, rows=both, of_model=())
    assert len(notes_of(several)) == 1
    assert len(every_note(several)) == 2


def test_what_is_not_known_is_counted(content: ReportContent) -> None:
    event = replace(content.events[0], volume_m3=None, year=None, left_profile=True, path_id=None)
    text = " ".join(unknown_words(replace(content, events=(event,), covariates={"snow": 1})))
    for words in ("no volume", "no date", "beyond its profile", "no path", "“snow”", "No speeds"):
        assert words in text


def test_every_picture_of_speed_carries_the_caveat(content: ReportContent) -> None:
    assert "no drag" in " ".join(assumptions(content))
    assert "no drag" in " ".join(reading_words(content))
    limited = replace(content, speed_limited=True)
    assert "no drag" not in " ".join((*assumptions(limited), *reading_words(limited)))
