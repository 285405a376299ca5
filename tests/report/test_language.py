"""Numbers, dates and sentences in the languages of the report."""

from __future__ import annotations

import re

import pytest

from avahazard.effects.catalogue import definition
from avahazard.notes import Note, grouped
from avahazard.records.errors import AvahazardError
from avahazard.report import words
from avahazard.report.language import ENGLISH, LANGUAGES, language_of, speaking
from avahazard.report.language import NARROW as S
from avahazard.workflow.requests import ReportRequest


@pytest.mark.parametrize(
    ("code", "number", "volume", "date"),
    [
        ("en", f"−12{S}345.6", f"123{S}000 m³", "1950-02-13"),
        ("de", f"−12{S}345,6", f"123{S}000 m³", "13.02.1950"),
        ("fr", f"−12{S}345,6", f"123{S}000 m³", "13 févr. 1950"),
        ("it", f"−12{S}345,6", f"123{S}000 m³", "13 feb 1950"),
    ],
)
def test_numbers_and_dates_have_the_form_of_the_language(
    code: str, number: str, volume: str, date: str
) -> None:
    language = language_of(code)
    assert language.number(f"{-12345.6:,.1f}") == number
    with speaking(language):
        assert words.volume(123456.0) == volume
    assert language.date("1950-02-13") == date
    assert language.date("1950") == "1950"
    assert language.date("winter 1950") == "winter 1950"


def test_english_is_as_results_say_it() -> None:
    assert language_of("en") is ENGLISH
    assert ENGLISH.note(Note("stale", model="m")) == Note("stale", model="m")
    assert ENGLISH.effect("forest-drag") == "forest-drag"
    assert ENGLISH.date("1950-02-13") == "1950-02-13"


def test_there_are_no_other_languages() -> None:
    with pytest.raises(AvahazardError, match="'es'") as refused:
        ReportRequest(language="es")  # type: ignore[arg-type]
    assert all(code in str(refused.value.hint) for code in LANGUAGES)


def test_numbers_of_things_follow_the_language() -> None:
    with speaking(language_of("fr")):
        assert [words.paths(n) for n in (0, 1, 2)] == ["0 couloir", "1 couloir", "2 couloirs"]
    with speaking(language_of("it")):
        assert [words.events(n) for n in (0, 1, 2)] == ["0 eventi", "1 evento", "2 eventi"]
    assert words.events(2) == "2 events"


def test_a_note_is_said_in_the_language_with_its_numbers() -> None:
    note = Note("rising_friction", share=0.12, smallest=500.0, largest=120000.0)
    said = language_of("de").note(note)
    assert said.startswith("In 12\u00a0% der Ziehungen")
    assert f"(500 bis 120{S}000 m³)" in said
    assert language_of("de").note(note.about(*"ABCDEF")).startswith("A, B, C und 3 weitere: In 12")
    assert f"(500 to 120{S}000 m³)" in ENGLISH.note(note)


def test_notes_within_a_note_are_said_in_the_language_too() -> None:
    parts = [Note("of_parameters"), Note("of_rate_error")]
    said = language_of("it").note(
        Note("interval_design", parts=parts, mixed=[Note("of_all_volumes")])
    )
    for item in ("incertezza dei parametri calibrati", "errore della frequenza", "tutti i volumi"):
        assert item in said
    remedy = Note("add_effect", model="base", effect="path-effect")
    spread = Note("paths_differ", sd=0.123, nats=9.0, model="base", remedy=remedy)
    said = language_of("fr").note(spread)
    assert "0,12" in said
    assert "+9 nats" in said
    assert "path-effect" in said


def test_effects_have_names_in_a_language() -> None:
    german = language_of("de")
    assert german.effects(["season", "covariate:wind"]) == "Jahreszeit und Spalte wind"
    assert german.effect("my-own") == "my-own"


def test_ranges_and_counts_are_said_in_the_language() -> None:
    notes = [Note("misses_points", f"P{k}", away=10.0 + k, x=1234.0) for k in range(2)]
    (one,) = grouped(notes)
    assert "um 10 bis 11 m" in language_of("de").note(one)
    few = Note("few_events", model="m", n=1)
    assert language_of("it").note(few) == "m poggia solo su 1 evento."


@pytest.mark.parametrize("code", LANGUAGES)
def test_a_report_has_no_commands_and_names_for_columns(code: str) -> None:
    note = Note("no_zones", model="m")
    assert "avahazard zones m" in note
    assert "avahazard" not in language_of(code).note(note)
    levels = Note("levels", column="snow_type", events=3, parts=["2 dry", "1 wet"])
    with speaking(language_of(code)):
        pair = language_of(code).effect("interaction:snow_type*volume_m3")
        assert ("snow_type" in pair + language_of(code).note(levels)) == (code == "en")


@pytest.mark.parametrize("code", LANGUAGES)
def test_names_and_unknown_sentences_are_left_as_they_are(code: str) -> None:
    language = language_of(code)
    for text in ("Val d'Arly", "<img src=x>", "{model}", "Nobody ever said this, red or not."):
        assert language.note(text) == text
    assert language.effect("my-own") == "my-own"
    assert "wind_{x}" in language.effect("covariate:wind_{x}")
    for key in ("force:speed", "interaction:a*b", "scatter:a", "change:all"):
        assert language_of("de").effect(key) != key


def test_what_a_made_effect_means_is_said_in_the_words_of_its_kind() -> None:
    german = language_of("de")
    kinds = "covariate:wind interaction:wind*depth change:all change:P1 scatter:wind path:P1"
    for key in kinds.split():
        words = definition(key).meaning
        said = german.meaning(key, words)
        assert said != words
        assert all(name in said for name in re.findall("wind|depth|P1", key))
    assert german.meaning("my-own", "It is windy.") == "It is windy."
    assert language_of("en").meaning("path:P1", definition("path:P1").meaning).count("P1") == 1
