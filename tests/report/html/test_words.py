"""Numbers in words."""

from __future__ import annotations

from avahazard.notes import Note
from avahazard.report.html import words
from avahazard.report.html.content import EventView
from avahazard.report.language import language_of

S = words.NARROW


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


def test_an_interval_says_what_lies_beyond() -> None:
    assert words.interval({"q05": 900.0, "q95": 1000.0}) == f"900 to 1{S}000 m"
    assert words.interval({"q05": 900.0, "q95": None}) == "900 to beyond"
    assert words.interval({"q05": None, "q95": None}) == "beyond"


def test_the_case_of_a_row() -> None:
    assert words.case({"return_period_years": 30.0, "volume_m3": 1.0}) == "30 years"
    assert words.case({"return_period_years": None, "volume_m3": 2e4}) == f"20{S}000 m³"


def test_an_event_is_named_with_what_is_known() -> None:
    event = EventView(
        "e1", "P", "1950", 1950, None, False, "elevation", 900.0, 10.0, 800.0, 0.5, "unique"
    )
    assert words.event_words(event, {"P": "Path"}) == "e1 · Path · 1950 · volume unknown"


def test_a_gain_is_a_ratio_in_words() -> None:
    assert words.likelier(0.7) == "2.0 times"
    assert words.likelier(4.605) == "100 times"
    assert words.likelier(30.0) == "10¹³ times"
    assert words.likelier(-0.1) == "no"


def test_levels_have_the_words_and_signs_of_the_language() -> None:
    german = language_of("de")
    volume = Note("up_to", edge=4.2e4, form=",.0f", unit=" m3")
    column = Note("from_to", low=-7.13, high=-4.5, form=".4g", unit="")
    share = Note("above", edge=0.37, form=".0%", unit="")
    assert words.level_words(volume, german) == "bis 42.000 m³"
    assert words.level_words(column, german) == "−7,13 bis −4,5"
    assert words.level_words(share, german) == "über 37\u00a0%"
    assert words.level_words("March", german) == "März"
    assert words.level_words("channelled", german) == "kanalisiert"
    assert words.level_words("P01", german) == "P01"
