"""The verdict in words."""

from __future__ import annotations

import pytest

from avahazard.report.verdict_words import verdict_words


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
    document = {"verdict": verdict, "missing": ["season"], "detectable_m": 25.0}
    sentence = verdict_words(document, "base")
    assert sentence.startswith("base ")
    assert words in sentence
