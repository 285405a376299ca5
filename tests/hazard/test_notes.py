"""What a reader of a row must know, and what its intervals hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.extremes import one_volume
from avahazard.hazard.path_hazard import PathHazard, Varying, path_hazard
from avahazard.hazard.rows import (
    Scenario,
    design_interval,
    natural_parts,
    parameters_interval,
    row_interval,
    row_notes,
)
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.notes import Note
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.results.hazard import PlaceQuantiles
from tests.gis.results import DESIGN_RUNOUT
from tests.hazard.parabola import draws, path, path_rows
from tests.results.samples import HAZARD_ROW


@pytest.fixture(scope="module")
def plain() -> PathHazard:
    return path(draws(0.1, 20), one_volume(1e5, 20))


def told(given: PathHazard, **more: object) -> str:
    row = replace(HAZARD_ROW, **{"return_period_years": 100.0, "design": DESIGN_RUNOUT, **more})
    return " ".join(row_notes(given, row))


def test_nothing_to_say(plain: PathHazard) -> None:
    assert told(plain) == ""


def test_each_note(plain: PathHazard) -> None:
    assert "does not start in 12%" in told(plain, p_not_released=0.12)
    assert "100 years are over twice" in told(plain, extrapolated=True)
    assert "were not over 0" in told(plain, n_nonpositive_friction=3)
    assert "no design runout" in told(replace(plain, rate_known=False))
    beyond = replace(DESIGN_RUNOUT, p_beyond=0.2)
    assert "part of the interval of the 100-year" in told(plain, design=beyond)
    wholly = replace(DESIGN_RUNOUT, p_beyond=1.0)
    assert "the 100-year runout is beyond the end of the profile" in told(plain, design=wholly)


def test_scatter_in_metres_that_ends_at_the_lowest_place_is_told(plain: PathHazard) -> None:
    metres = path(draws(40.0, 2), one_volume(1e5, 2), metres=True)
    assert "lowest place" not in told(metres)
    flat = replace(DESIGN_RUNOUT, runout_x_m=PlaceQuantiles(1500.0, 2000.0, 2000.0))
    assert "the 100-year runout is at the lowest place" in told(metres, design=flat)
    assert told(plain, design=flat) == ""


@pytest.mark.parametrize(
    ("share", "law"), [(0.25, "exponential"), (1.0, "power"), (0.025, "power"), (0.0, "power")]
)
def test_larger_avalanches_that_stop_earlier_are_told_with_their_probability(
    share: float, law: str
) -> None:
    x = np.arange(0.0, 3601.0, 30.0)
    y = 2500.0 - 0.9 * x + 1.2e-4 * x**2
    events = tuple(
        Event(f"e{v:g}", path_id="p", volume_m3=v, runout_x_m=1500.0) for v in (2e3, 1e4, 3e5)
    )
    records = Records((Path("p"),), (Profile("p", x, y),), events)
    coordinates = draws(0.1, 40)
    coordinates[:, 0] = np.log(0.35 if law == "power" else 0.55)
    steepness = 0.05 if law == "power" else 2.0
    coordinates[:, 1] = np.where(np.arange(40) < 40 * share, -steepness, steepness)
    posterior = Posterior(build_observations(records), Specification(law=law), ())
    given = path_hazard(
        *(fitted_model(posterior, coordinates, {}), records, "p", one_volume(1e4, 40, 0.3), [1e4]),
        seed=0,
    )
    if given.rising is not None:
        assert given.rising.values == {"share": share, "smallest": 2e3, "largest": 3e5}
    (row,) = path_rows(given, [Scenario("p", 1e4, 100.0)], 500, 0)
    words = f"in {share:.0%} of the draws larger avalanches stop earlier"
    assert (words in " ".join(row.notes)) == (share > 0.05)
    assert ("2,000 to 300,000 m3" in " ".join(row.notes)) == (share > 0.05)
    assert row.design.n_records == 3
    assert row.design.farthest_record.runout_x_m == 1500.0


@pytest.fixture(scope="module")
def two() -> PathHazard:
    return path(draws(0.1, 2), None)


def natural_of(given: PathHazard) -> Note:
    return Note("interval_nature", parts=natural_parts(given))


def test_what_varies_is_named_and_nothing_else(two: PathHazard) -> None:
    text = row_interval(two, return_period=False)
    assert "friction (lognormal)" in text
    for part in ("Student t", "release", "columns", "without records"):
        assert part not in text
    more = replace(two, varying=Varying(release=True, columns=True), offset_unknown=True)
    text = row_interval(more, return_period=False)
    for part in ("the release", "columns of the event", "path without records"):
        assert part in text
    # What is not known of the path does not vary from avalanche to avalanche.
    assert "without records" not in natural_of(more)
    assert "without records" in parameters_interval(more, return_period=False)


def test_the_family_of_the_scatter() -> None:
    student = path(draws(0.1, 2), None, specification=Specification(tails="student"))
    assert "Student t" in natural_of(student)
    normal = path(draws(0.1, 2), None, specification=Specification(distribution="normal"))
    assert "(normal)" in natural_of(normal)
    metres = path(draws(40.0, 2), None, metres=True)
    assert "sigma metres of elevation" in natural_of(metres)


def test_a_volume_that_does_not_matter_has_no_error(two: PathHazard) -> None:
    without = replace(two, varying=Varying(volume=False))
    assert "does not matter" in row_interval(without, return_period=True)
    assert "volume" not in design_interval(without)
    assert "all volumes" in design_interval(two)
    assert "error of the volume" not in parameters_interval(without, return_period=True)
    assert "error of the volume" in parameters_interval(two, return_period=True)


def test_the_offset_of_a_path_is_unknown_where_paths_differ_and_it_has_no_records(
    two: PathHazard,
) -> None:
    assert not two.offset_unknown
    assert np.all(two.draws.shift(np.random.default_rng(0)) == 0.0)
