"""Numbers in words."""

from __future__ import annotations

from dataclasses import replace

from avahazard.notes import Note
from avahazard.report import words
from avahazard.report.html.content import EventView
from avahazard.report.language import NARROW as S
from avahazard.report.language import TERMINAL, language_of, speaking
from avahazard.results.hazard import PlaceQuantiles
from tests.results.samples import HAZARD_ROW


def test_numbers() -> None:
    assert words.integer(-12345.6) == f"−12{S}346"
    assert words.metres(1234.4) == f"1{S}234 m"
    assert words.metres(None) == "beyond"
    assert words.volume(123456.0) == f"123{S}000 m³"
    assert words.volume(None) == "any"
    assert words.number(3.167e-7) == "3.17 × 10⁻⁷"
    assert words.number(-0.25) == "−0.25"
    assert words.number(None) == "–"
    assert words.chance(0.0004) == "< 0.001"
    assert words.chance(0.25) == "0.250"
    assert words.chance(0.005, 1 / 200) == "< 1/200"
    assert words.chance(0.01, 1 / 200) == "0.010"
    assert words.chance(0.025, 1 / 40) == "< 1/40"
    assert words.paths(1) == "1 path"
    assert words.paths(2) == "2 paths"


def test_a_share_is_never_nothing_where_it_is_something() -> None:
    assert [words.share(p) for p in (0.0, 1e-5, 0.012, 0.5, 1.0)] == [
        "0.0 %", "under 0.1 %", "1.2 %", "50 %", "100 %",
    ]  # fmt: skip


def test_nothing_is_less_than_zero_and_shown_as_zero() -> None:
    assert [words.digits(v, ".1f") for v in (-0.04, -0.06, None)] == ["0.0", "−0.1", None]
    assert words.digits(-0.04, "+.1f") == "0.0"


def test_an_interval_says_what_lies_beyond() -> None:
    sure, open_end, beyond = (
        PlaceQuantiles(low, None, high)
        for low, high in ((900.0, 1000.0), (900.0, None), (None, None))
    )
    assert words.interval(sure) == f"900 to 1{S}000 m"
    assert words.interval(open_end) == "900 to beyond"
    assert words.interval(beyond) == words.span(beyond) == "beyond"
    assert words.span(open_end) == "900–beyond"
    with speaking(TERMINAL):
        assert words.span(sure) == "900–1000"
        assert words.span(open_end) == "900–…"


def test_the_case_of_a_row() -> None:
    assert words.case(replace(HAZARD_ROW, return_period_years=30.0)) == "30 years"
    assert words.case(replace(HAZARD_ROW, volume_m3=2e4)) == f"20{S}000 m³"


@speaking(TERMINAL)
def test_a_terminal_has_the_numbers_of_programs() -> None:
    assert words.number(3.167e-7) == "3.17e-07"
    assert words.metres(12345.0) == "12345 m"
    assert words.as_sure_as(0.0073, 0.51872) == "0.5187"
    assert words.as_sure_as(0.0, 1.0) == "1"


def test_an_event_is_named_with_what_is_known() -> None:
    event = EventView("e1", "P", "1950", stop_x_m=800.0)
    assert words.event_text(event, {"P": "Path"}) == "e1 · Path · 1950 · volume unknown"


@speaking(language_of("de"))
def test_levels_have_the_words_and_signs_of_the_language() -> None:
    volume = Note("up_to", edge=4.2e4, form=",.0f", unit=" m3")
    column = Note("from_to", low=-7.13, high=-4.5, form=".4g", unit="")
    share = Note("above", edge=0.37, form=".0%", unit="")
    assert words.level_text(volume) == f"bis 42{S}000 m³"
    assert words.level_text(column) == "−7,13 bis −4,5"
    assert words.level_text(share) == "über 37\u00a0%"
    assert words.level_text("March") == "März"
    assert words.level_text("channelled") == "kanalisiert"
    assert words.level_text("P01") == "P01"
