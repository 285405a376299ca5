"""Columns in other spellings."""

from __future__ import annotations

import pytest

from avahazard.records.forms import COLUMNS
from avahazard.records.meanings import (
    ABOVE_SEA,
    MEANINGS,
    factor,
    known_name,
    near_name,
    one_spelling,
    plain_word,
)


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("volume_m3", "volume_m3"),
        ("Volume_m3", "volume_m3"),
        ("Volume (m³)", "volume_m3"),
        ("VOLUME [m3]", "volume_m3"),
        ("Date", "date"),
        ("OBSERVED_FROM", "observed_from"),
        ("observed from", "observed_from"),
        ("Event ID", "event_id"),
        ("EventId", "event_id"),
        ("Speed (m/s)", "speed_m_s"),
        ("aspect", None),
        ("volume", None),
        ("volume_km3", None),
    ],
)
def test_spellings(name: str, column: str | None) -> None:
    assert known_name(name) == column


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("volume", "volume_m3"),
        ("Volume_km3", "volume_m3"),
        ("volme_m3", "volume_m3"),
        ("vloume_m3", "volume_m3"),
        ("runout elevation", "runout_elevation_m"),
        ("left_profil", "left_profile"),
        ("snow_types", "snow_type"),
        ("rate", None),
        ("aspect", None),
        ("snow_temperature_c", None),
        ("mean_slope_deg", None),
        ("deposit_area_m2", None),
    ],
)
def test_near_misses(name: str, column: str | None) -> None:
    assert near_name(name, sorted(COLUMNS["events"])) == column


def test_every_column_of_a_form_has_a_meaning() -> None:
    assert set().union(*COLUMNS.values()) <= MEANINGS.keys()


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("Depth-Hoar", "depth hoar"),
        (" depth  hoar", "depth hoar"),
        ("DEPTH_HOAR", "depth hoar"),
        # A sign at the end or beside a number counts, and a single letter may be a code.
        ("A-", "a-"),
        ("S-1", "s-1"),
        ("N", "N"),
        ("n", "n"),
    ],
)
def test_how_a_value_is_spelled_does_not_count(text: str, plain: str) -> None:
    assert plain_word(text) == plain


def test_the_most_common_spelling_is_kept() -> None:
    texts = ["wind slab", "Wind-slab", "wind slab", "", "powder", "Powder"]
    assert one_spelling(texts) == {
        "wind slab": "wind slab",
        "Wind-slab": "wind slab",
        "powder": "Powder",
        "Powder": "Powder",
    }


@pytest.mark.parametrize(
    ("text", "unit", "times"),
    [
        ("cu yd", "m3", 0.764554857984),
        ("cu. ft", "m3", 0.028316846592),
        ("yd3", "m3", 0.764554857984),
        ("cubic yards", "m3", 0.764554857984),
        ("m ü. M.", ABOVE_SEA, 1.0),
        ("ft asl", ABOVE_SEA, 0.3048),
        ("m ü. M.", "m", None),
        ("Mm3", "m3", None),
    ],
)
def test_units_as_people_write_them(text: str, unit: str, times: float | None) -> None:
    assert factor(text, unit) == (times and pytest.approx(times))
