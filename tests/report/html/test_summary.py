"""What the first page says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avahazard.notes import Note
from avahazard.report.html.content import ReportContent
from avahazard.report.html.summary import model_words, sure_words, why_words
from avahazard.report.html.unknowns import assumptions, cannot_tell, unknown_words, zone_words
from avahazard.report.language import ENGLISH
from avahazard.results.base import Rows
from avahazard.results.comparison import Failure
from tests.report.html.world import NAMES
from tests.telling import untold


def said(content: ReportContent, **change: Any) -> str:
    return " ".join(cannot_tell(replace(content, **change)))


def test_the_model_is_told(content: ReportContent) -> None:
    text = " ".join(model_words(content))
    assert untold(text, "61 events", "3 paths", "exponential") == []
    metropolis = replace(
        content.model,
        method="metropolis",
        effects=("season",),
        parent="p",
        centrifugal=False,
        law="power",
    )
    text = " ".join(model_words(replace(content, model=metropolis)))
    assert "metres of elevation" in text
    assert "season" in text
    assert "“p”" in text
    assert "left out" in text


def test_why_is_the_held_out_error_of_the_ladder(content: ReportContent) -> None:
    assert why_words(content) == []  # one model has nothing to be measured against
    (row,) = content.ladder
    ladder = [replace(row, held_out_crps_m=40.0), replace(row, model="p", held_out_crps_m=50.0)]
    child = replace(content.model, parent="p")
    text = " ".join(why_words(replace(content, ladder=ladder, model=child)))
    assert untold(text, "least error", "40.0 m", "“p”", "50.0 m") == []
    ladder[0] = replace(row, held_out_crps_m=60.0)
    (words,) = why_words(replace(content, ladder=ladder, model=child))
    assert "“p” has the least error" in words


def test_how_sure_is_the_held_out_error_beside_the_floor(content: ReportContent) -> None:
    comparison = content.comparison
    assert comparison is not None
    held = comparison.held_out.runout
    text = " ".join(sure_words(content))
    assert f"{held.crps_m:.1f} m of elevation" in text
    assert "m of distance along the path" in text
    assert "whatever the model" not in text
    assert f"{held.rmse_m:.0f} m" in text
    assert f"{held.noise_floor_m:.0f} m" in text
    assert "fails nowhere" in text
    worse = replace(comparison, where_it_fails=Rows([Failure("snow_type", "wet", 9, -50.0, 0.001)]))
    assert "snow type, “wet”" in " ".join(sure_words(replace(content, comparison=worse)))
    assert sure_words(replace(content, comparison=None)) == []


def test_what_it_cannot_tell_comes_from_the_results(content: ReportContent) -> None:
    assert "extrapolation" in said(content)  # 300 years of a record of 100
    assert "season" in said(content)
    assert "never diagnosed" in said(content, diagnosis=None)
    assert "never set against" in said(content, comparison=None)
    assert "have changed" in said(content, records_changed=True)
    checks = replace(content.model.diagnostics, converged=False)
    assert "provisional" in said(content, model=replace(content.model, diagnostics=checks))
    row = dict(content.rows[0])
    name = NAMES[row["path_id"]]
    stale, unconverged = Note("stale", model="m"), Note("unconverged", model="m")
    twice = Note("recorded_twice", "e1 = e2")
    own = [{"key": "extrapolated", "values": {"period": 500.0}}, "as it was said before."]
    noted = {**row, "notes": [*own, stale, unconverged.stored(), twice.stored()]}
    text = said(content, rows=[noted], of_model=(twice,))
    assert f"{name}: 500 years are over twice the observed years" in text
    assert f"{name}: as it was said before." in text
    assert "since m was calibrated" not in text  # said once, of the model as it is now
    assert "chains of m" not in text
    assert f"{name}: e1 = e2" not in text  # of the model: on no path more than on another
    assert text.count("e1 = e2: alike in path, day and stop") == 1
    few = replace(content.paths[0], events=())
    assert "fewer than 5" in said(content, paths=(few, *content.paths[1:]))


def test_what_is_not_known_is_counted(content: ReportContent) -> None:
    event = replace(content.events[0], volume_m3=None, year=None, left_profile=True, path_id=None)
    text = " ".join(unknown_words(replace(content, events=(event,), covariates={"snow": 1})))
    for words in ("no volume", "no date", "left its profile", "no path", "“snow”", "No speeds"):
        assert words in text


def test_the_limits_name_what_the_report_holds(content: ReportContent) -> None:
    text = " ".join(assumptions(content))
    assert ENGLISH.note(content.rows[0]["interval"]) in text
    assert ENGLISH.note(content.rows[0]["design"]["interval"]) in text
    assert "no drag" in text
    assert "kg/m³" in " ".join(zone_words(content))
    assert "no drag" not in " ".join(assumptions(replace(content, speed_limited=True)))
    assert zone_words(replace(content, paths=())) == []
