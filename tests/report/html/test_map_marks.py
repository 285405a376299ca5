"""Scale and north of a map."""

from __future__ import annotations

import pytest

from avahazard.report.html.map_marks import M_PER_DEGREE, round_length, scale_bar
from avahazard.report.language import ENGLISH, language_of


@pytest.mark.parametrize(
    ("most", "found"), [(999.0, 500.0), (1000.0, 1000.0), (430.0, 200.0), (0.3, 0.2), (7.0, 5.0)]
)
def test_lengths_are_round(most: float, found: float) -> None:
    assert round_length(most) == pytest.approx(found)


def test_the_bar_is_as_long_as_it_says() -> None:
    bar = scale_bar((0.0, 4000.0), (0.0, 3000.0), degrees=False, language=ENGLISH)
    assert max(bar["x"]) - min(bar["x"]) == 1000.0
    assert "1\u202f000 m" in bar["text"]
    assert "1.000 m" in scale_bar((0.0, 4000.0), (0.0, 1.0), False, language_of("de"))["text"]


def test_a_degree_of_longitude_shrinks_towards_the_pole() -> None:
    bar = scale_bar((10.0, 10.1), (59.95, 60.05), degrees=True, language=ENGLISH)
    assert "1\u202f000 m" in bar["text"]
    assert (max(bar["x"]) - min(bar["x"])) * M_PER_DEGREE * 0.5 == pytest.approx(1000.0, rel=1e-3)
