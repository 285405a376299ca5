"""Which candidates there are."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from avahazard.criticism.screening.screen import candidate_definitions, not_asked
from avahazard.effects.motion import STATES
from avahazard.effects.own_file import TEMPLATE, definition_from
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from tests.criticism.lengths import lengths
from tests.inference import studies


def keys(observations, specification=Specification(), own=()):  # type: ignore[no-untyped-def] # noqa: B008
    return [d.key for d in candidate_definitions(observations, specification, own)]


def test_what_the_model_has_is_no_candidate() -> None:
    observations = studies.observations()
    found = keys(observations)
    assert {"turbulent-drag", "snow-type", "volume-law", "volume-scatter"} <= set(found)
    assert "centrifugal" not in found
    assert "path-effect" not in found
    assert "snow-type" not in keys(observations, Specification(effects=("snow-type",)))
    assert "volume-scatter" not in keys(observations, Specification(scatter="volume"))
    assert "centrifugal" in keys(observations, Specification(centrifugal=False))


def test_every_column_has_a_smooth_but_those_with_an_effect_of_their_own() -> None:
    found = keys(studies.observations())
    assert {"covariate:wind", "covariate:year", "covariate:release_elevation_m"} <= set(found)
    assert "covariate:snow_type" not in found
    assert len(found) == len(set(found))


def test_where_a_path_faces_is_asked_as_numbers() -> None:
    observations = studies.observations()
    names = observations.columns.paths
    faces = np.array(["N", "E", "SW"])[observations.columns.path_index % 3]
    columns = replace(
        observations.columns,
        texts={**observations.columns.texts, "orientation": faces},
        numbers={**observations.columns.numbers, "northness": np.linspace(-1.0, 1.0, len(faces))},
    )
    found = keys(replace(observations, columns=columns))
    assert len(names) > 2
    assert "covariate:northness" in found
    assert "interaction:wind*northness" in found
    assert not any("orientation" in key for key in found)


def test_a_direction_beside_another_column_is_two_parts() -> None:
    """By its degrees as a line, what acts on lee slopes was named as two false products."""
    records = studies.records(speeds=False)
    rng = np.random.default_rng(3)
    blown = [
        replace(e, covariates={**e.covariates, "wind_dir": float(rng.integers(360))})
        for e in records.events
    ]
    found = keys(build_observations(replace(records, events=tuple(blown))))
    assert {"covariate:wind_dir", "covariate:wind_dir_north"} <= set(found)
    assert "interaction:wind*wind_dir_east" in found
    assert "interaction:wind*wind_dir" not in found


def test_scatter_may_change_over_the_years() -> None:
    assert "scatter:year" in keys(studies.observations())


def test_a_forest_by_another_name_is_said() -> None:
    records = studies.records(speeds=False)
    wooded = [
        replace(p, land_cover=("offen",) + ("Wald",) * (len(p.x_m) - 1)) for p in records.profiles
    ]
    lacks = not_asked(build_observations(replace(records, profiles=tuple(wooded))), Specification())
    assert "there is Wald, offen" in lacks["forest-drag"]


def test_without_a_profile_no_motion_can_be_told() -> None:
    found = keys(build_observations(lengths()))
    columns = ["rock", "column_1", "column_2", "column_3"]
    pairs = combinations(["column_1", "column_2", "column_3", "rock", "volume_m3"], 2)
    assert set(found) == {
        "volume-law", "volume-scatter", "record-error", "volume-error", "two-kinds",
        "covariate:volume_m3",
        *(f"covariate:{column}" for column in columns),
        *(f"scatter:{column}" for column in columns),
        *(f"interaction:{one}*{other}" for one, other in pairs),
    }  # fmt: skip
    assert len(found) == len(set(found))


def test_beyond_the_catalogue_stand_forces_dates_and_what_the_records_count() -> None:
    found = set(keys(studies.observations()))
    assert {f"force:{state}" for state in STATES} | {"force:speed"} <= found
    assert "change:all" in found
    assert {"covariate:order_in_winter", "scatter:avalanches_nearby"} & found == set()
    assert "force:slope" not in keys(
        studies.observations(), Specification(effects=("force:slope",))
    )


def test_whether_a_column_matters_may_hang_on_what_every_record_has() -> None:
    found = set(keys(studies.observations()))
    for other in ("day_of_winter", "release_elevation_m", "volume_m3", "path_id"):
        assert f"interaction:wind*{other}" in found
    assert {"scatter:wind", "scatter:day_of_winter", "scatter:release_elevation_m"} <= found


def test_a_limit_that_is_known_everywhere_is_no_candidate() -> None:
    records = studies.records(speeds=False)
    assert "observation-limit" in keys(build_observations(records))
    paths = tuple(replace(p, observed_below_m=600.0) for p in records.paths)
    assert "observation-limit" not in keys(build_observations(replace(records, paths=paths)))


def test_the_users_own_effect_comes_along() -> None:
    own = definition_from(TEMPLATE, "mine.py")
    assert own.key in keys(studies.observations(), own=(own,))
    assert own.key not in keys(build_observations(lengths()), own=(own,))


def test_a_column_that_tells_too_little_is_not_passed_over_in_silence() -> None:
    records = studies.records(speeds=False)
    few = [
        replace(e, covariates={**e.covariates, "snow_type": "wet" if k < 4 else "dry"})
        for k, e in enumerate(records.events)
    ]
    observations = build_observations(replace(records, events=tuple(few)))
    assert "snow-type" not in keys(observations)
    assert not_asked(observations, Specification()) == {
        "snow-type": "snow_type has no two values with at least 5 events each"
    }
    assert not_asked(observations, Specification(effects=("snow-type",))) == {}
    assert not_asked(studies.observations(), Specification()) == {}
