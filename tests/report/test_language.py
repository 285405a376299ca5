"""Numbers, dates and sentences in the languages of the report."""

from __future__ import annotations

import pytest

from avahazard.criticism.diagnosis.measurements import UNLINKED
from avahazard.hazard.notes import RISING, stale_words
from avahazard.hazard.words import ALL_VOLUMES, EXCEEDED, PARAMETERS, RATE_ERROR
from avahazard.inference.prediction.extrapolation import OUT_OF_BOUNDS
from avahazard.records.errors import AvahazardError
from avahazard.report.html import words
from avahazard.report.language import ENGLISH, LANGUAGES, language_of
from avahazard.results.calibration import PathSpread

S = words.NARROW


@pytest.mark.parametrize(
    ("code", "number", "volume", "date"),
    [
        ("en", f"−12{S}345.6", f"123{S}000 m³", "1950-02-13"),
        ("de", "−12.345,6", "123.000 m³", "13.02.1950"),
        ("fr", f"−12{S}345,6", f"123{S}000 m³", "13 févr. 1950"),
        ("it", "−12.345,6", "123.000 m³", "13 feb 1950"),
    ],
)
def test_numbers_and_dates_have_the_form_of_the_language(
    code: str, number: str, volume: str, date: str
) -> None:
    language = language_of(code)
    assert language.number(f"{-12345.6:,.1f}") == number
    assert words.volume(123456.0, language) == volume
    assert language.date("1950-02-13") == date
    assert language.date("1950") == "1950"
    assert language.date("winter 1950") == "winter 1950"


def test_english_is_as_results_say_it() -> None:
    assert language_of("en") is ENGLISH
    assert ENGLISH.told(stale_words("m")) == stale_words("m")
    assert ENGLISH.effect("forest-drag") == "forest-drag"
    assert ENGLISH.date("1950-02-13") == "1950-02-13"


def test_there_are_no_other_languages() -> None:
    with pytest.raises(AvahazardError, match="'es'") as refused:
        language_of("es")
    assert all(code in str(refused.value.hint) for code in LANGUAGES)


def test_numbers_of_things_follow_the_language() -> None:
    assert [words.paths(n, language_of("fr")) for n in (0, 1, 2)] == [
        "0 couloir", "1 couloir", "2 couloirs",
    ]  # fmt: skip
    assert [words.events(n, language_of("it")) for n in (0, 1, 2)] == [
        "0 eventi", "1 evento", "2 eventi",
    ]  # fmt: skip


def test_a_sentence_of_a_result_is_found_by_its_places() -> None:
    german = language_of("de")
    told = german.told(RISING.format(share="12%", smallest="500", largest="120000"))
    assert told.startswith("In 12 % der Ziehungen")
    assert "(500 bis 120.000 m³)" in told


def test_a_volume_and_a_share_that_follow_each_other_are_told_apart() -> None:
    told = OUT_OF_BOUNDS.format(
        volume="1e+07 m3", share="97%", side="under", limit="0.1", median="0.02"
    )
    assert "für 10.000.000 m³ liegen 97 % der" in language_of("de").told(told).replace(
        "\u00a0", " "
    )


def test_lists_in_a_sentence_are_translated_item_by_item() -> None:
    parts = f"{PARAMETERS}, {RATE_ERROR}"
    told = language_of("it").told(EXCEEDED.format(parts=parts, mixed=ALL_VOLUMES))
    for item in ("incertezza dei parametri calibrati", "errore della frequenza", "tutti i volumi"):
        assert item in told


def test_a_sentence_within_a_sentence_is_translated_too() -> None:
    spread = PathSpread(sd=0.123, evidence=9.0, n_paths=20, effect="path-effect")
    told = language_of("fr").told(spread.note("base"))
    assert "0,12" in told
    assert "plus de 1000 contre 1" in told
    assert "avahazard add base path-effect --as NEW" in told


def test_effects_have_names_where_they_are_told_and_keys_in_commands() -> None:
    told = language_of("de").told(UNLINKED.format(n=20, one="season", other="covariate:wind"))
    assert "Jahreszeit und Spalte wind" in told


@pytest.mark.parametrize("code", LANGUAGES)
def test_names_and_unknown_sentences_are_left_as_they_are(code: str) -> None:
    language = language_of(code)
    for text in ("Val d'Arly", "<img src=x>", "{model}", "Nobody ever said this, red or not."):
        assert language.told(text) == text
    assert language.effect("my-own") == "my-own"
    assert "wind_{x}" in language.effect("covariate:wind_{x}")
