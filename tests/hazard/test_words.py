"""What the intervals hold, in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.path_hazard import PathHazard, Varying
from avahazard.hazard.words import (
    design_words,
    interval_words,
    natural_words,
    parameters_words,
)
from avahazard.inference.model.specification import Specification
from tests.hazard.parabola import draws, path


@pytest.fixture(scope="module")
def plain() -> PathHazard:
    return path(draws(0.1, 2), None)


def test_what_varies_is_named_and_nothing_else(plain: PathHazard) -> None:
    text = interval_words(plain, return_period=False)
    assert "friction (lognormal)" in text
    for part in ("Student's t", "release", "columns", "without records"):
        assert part not in text
    more = replace(plain, varying=Varying(release=True, columns=True), offset_unknown=True)
    text = interval_words(more, return_period=False)
    for part in ("the release", "columns of the event", "path without records"):
        assert part in text
    # What is not known of the path does not vary from avalanche to avalanche.
    assert "without records" not in natural_words(more)
    assert "without records" in parameters_words(more, return_period=False)


def test_the_family_of_the_scatter() -> None:
    student = path(draws(0.1, 2), None, specification=Specification(tails="student"))
    assert "Student's t" in natural_words(student)
    normal = path(draws(0.1, 2), None, specification=Specification(distribution="normal"))
    assert "(normal)" in natural_words(normal)
    metres = path(draws(40.0, 2), None, metres=True)
    assert "sigma metres of elevation" in natural_words(metres)


def test_a_volume_that_does_not_matter_has_no_error(plain: PathHazard) -> None:
    without = replace(plain, varying=Varying(volume=False))
    assert "does not matter" in interval_words(without, return_period=True)
    assert "volume" not in design_words(without)
    assert "all volumes" in design_words(plain)
    assert "error of the volume" not in parameters_words(without, return_period=True)
    assert "error of the volume" in parameters_words(plain, return_period=True)


def test_the_offset_of_a_path_is_unknown_where_paths_differ_and_it_has_no_records(
    plain: PathHazard,
) -> None:
    assert not plain.offset_unknown
    assert np.all(plain.draws.shift(np.random.default_rng(0)) == 0.0)
