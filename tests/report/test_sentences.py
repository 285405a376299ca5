"""The verdict in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.report.sentences import verdict_words
from tests.results.samples import DIAGNOSIS


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("missing-effect", "lacks an effect: season"),
        ("ambiguous", "cannot tell which"),
        ("unexplained", "no effect of the catalogue"),
        ("adequate", "25 m"),
    ],
)
def test_the_verdict_in_words(verdict: str, words: str) -> None:
    found = replace(DIAGNOSIS, verdict=verdict, missing=("season",))
    sentence = verdict_words(found, "base")
    assert sentence.startswith("base ")
    assert words in sentence


def test_the_verdict_says_where_the_physics_is() -> None:
    found = replace(
        DIAGNOSIS,
        verdict="missing-effect",
        missing=("forest-drag",),
        where=("It fails beyond chance on P01 (+40 m).", "P01 and P06 have forest."),
    )
    assert verdict_words(found).endswith("(+40 m). P01 and P06 have forest.")


@pytest.mark.parametrize(("share", "words"), [(0.6, "cannot tell"), (0.4, "adequate")])
def test_few_data_are_not_called_a_good_model(share: float, words: str) -> None:
    found = replace(DIAGNOSIS, verdict="adequate", missing=(), detectable_share=share)
    assert words in verdict_words(found, "base")
    assert found.cannot_tell == (share > 0.5)


def test_what_is_missing_is_named_however_few_the_data() -> None:
    found = replace(DIAGNOSIS, verdict="missing-effect", missing=("season",), detectable_share=0.9)
    assert "lacks an effect: season" in verdict_words(found, "base")
