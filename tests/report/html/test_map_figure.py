"""Scale and north of a map."""

from __future__ import annotations

from io import BytesIO

import matplotlib.image as mpimg
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from avahazard.report.html.map_figure import M_PER_DEGREE, TINT, hillshade, round_length, scale_bar
from avahazard.report.language import language_of, speaking
from avahazard.results.terrain import PERIOD_COLORS


@pytest.mark.parametrize(
    ("most", "found"), [(999.0, 500.0), (1000.0, 1000.0), (430.0, 200.0), (0.3, 0.2), (7.0, 5.0)]
)
def test_lengths_are_round(most: float, found: float) -> None:
    assert round_length(most) == pytest.approx(found)


def test_the_bar_is_as_long_as_it_says() -> None:
    bar = scale_bar((0.0, 4000.0), (0.0, 3000.0), degrees=False)
    assert max(bar["x"]) - min(bar["x"]) == 1000.0
    assert "1\u202f000 m" in bar["text"]
    other = scale_bar((0.0, 4000.0), (0.0, 3000.0), degrees=False, right=True)
    assert max(other["x"]) == 4000.0 - min(bar["x"])
    with speaking(language_of("de")):
        assert "1\u202f000 m" in scale_bar((0.0, 4000.0), (0.0, 1.0), False)["text"]


def test_a_degree_of_longitude_shrinks_towards_the_pole() -> None:
    bar = scale_bar((10.0, 10.1), (59.95, 60.05), degrees=True)
    assert "1\u202f000 m" in bar["text"]
    assert (max(bar["x"]) - min(bar["x"])) * M_PER_DEGREE * 0.5 == pytest.approx(1000.0, rel=1e-3)


def shade(elevation: np.ndarray) -> np.ndarray:
    return mpimg.imread(BytesIO(hillshade(elevation.astype(np.float32), 10.0)), format="png")


def test_slopes_that_face_the_light_are_brighter() -> None:
    row, column = np.mgrid[0:20, 0:20]
    # The light comes from the north-west, where row and column are 0.
    facing = shade(5.0 * (row + column))[10, 10, 0]
    flat = shade(np.zeros((20, 20)))[10, 10, 0]
    away = shade(-5.0 * (row + column))[10, 10, 0]
    assert facing > flat > away


def test_unknown_ground_is_clear_and_the_picture_always_the_same() -> None:
    ground = np.zeros((12, 15))
    ground[2, 3] = np.nan
    picture = shade(ground)
    assert picture.shape[:2] == (12, 15)
    assert picture[2, 3, 3] == 0.0
    assert picture[8, 8, 3] == 1.0
    assert hillshade(ground.astype(np.float32), 10.0) == hillshade(ground.astype(np.float32), 10.0)


@pytest.mark.parametrize("cell", [1.0, 50.0])
def test_the_slope_counts_and_not_the_rise_of_a_cell(cell: float) -> None:
    row, _ = np.mgrid[0:10, 0:10]
    picture = mpimg.imread(
        BytesIO(hillshade((0.5 * cell * row).astype(np.float32), cell)), format="png"
    )
    same = mpimg.imread(BytesIO(hillshade((5.0 * row).astype(np.float32), 10.0)), format="png")
    np.testing.assert_array_equal(picture, same)


def test_cells_have_the_colour_of_the_shortest_period_that_is_reached() -> None:
    chance = np.array([[0.0, 1 / 250], [1 / 50, 1 / 5]])
    flat = hillshade(np.zeros((2, 2), np.float32), 10.0)
    drawn = hillshade(np.zeros((2, 2), np.float32), 10.0, chance)
    plain, colored = (mpimg.imread(BytesIO(png), format="png") for png in (flat, drawn))
    assert np.array_equal(plain[0, 0], colored[0, 0])
    for place, period in (((0, 1), 300.0), ((1, 0), 100.0), ((1, 1), 10.0)):
        mixed = TINT * np.array(to_rgb(PERIOD_COLORS[period])) + (1.0 - TINT) * plain[place][:3]
        np.testing.assert_allclose(colored[place][:3], mixed, atol=0.01)
