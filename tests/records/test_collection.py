"""Finding paths by their names."""

from __future__ import annotations

import pytest

from avahazard.records.collection import (
    Path,
    Records,
    deposit_volume_m3,
    find_path,
    find_profile,
    only_paths,
    runout_sigma_m,
    speed_sigma_m_s,
)
from avahazard.records.errors import AvahazardError
from tests.workflow.twin import twin_records
from tests.workflow.worlds import bowl


def test_a_path_and_its_profile_are_found() -> None:
    records = bowl()
    assert find_path(records, "B") is records.paths[0]
    assert find_profile(records, records.paths[0]) is records.profiles[0]


def test_what_is_missing_is_said() -> None:
    with pytest.raises(AvahazardError) as unknown:
        find_path(bowl(), "C")
    assert unknown.value.hint == "The paths are: B."
    with pytest.raises(AvahazardError) as empty:
        find_path(Records(), "C")
    assert "avahazard import" in empty.value.hint
    many = Records(tuple(Path(f"p{i}") for i in range(15)))
    with pytest.raises(AvahazardError) as long:
        find_path(many, "C")
    assert long.value.hint.endswith("p11 and 3 more.")
    with pytest.raises(AvahazardError, match="No profile is stored for path p3"):
        find_profile(many, many.paths[3])


def test_paths_that_are_not_there_or_have_no_events() -> None:
    with pytest.raises(AvahazardError, match="no path 'nowhere'"):
        only_paths(twin_records(), ["scey", "nowhere"])
    with pytest.raises(AvahazardError, match="no events on B"):
        only_paths(bowl(), ["B"])
    some = only_paths(twin_records(), ["saugy", "scey"])
    assert {e.path_id for e in some.events} == {p.path_id for p in some.profiles}
    assert [p.path_id for p in some.paths] == ["saugy", "scey"]


@pytest.mark.parametrize(
    ("year", "sigma"), [(None, 10), (1700, 25), (1904, 25), (1940, 17.5), (1975, 10), (2020, 10)]
)
def test_runout_sigma_by_year(year: int | None, sigma: float) -> None:
    assert runout_sigma_m(year) == pytest.approx(sigma)


def test_deposit_is_half_a_block() -> None:
    assert deposit_volume_m3(100, 20, 3) == 3000


def test_speed_sigma_is_a_tenth_but_a_metre_per_second() -> None:
    assert [speed_sigma_m_s(v) for v in (0.0, 5.0, 30.0)] == [1, 1, 3]
