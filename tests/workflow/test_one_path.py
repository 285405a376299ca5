"""Finding a path by its name."""

from __future__ import annotations

import pytest

from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.path import Path
from avahazard.workflow.one_path import find_path, find_profile, path_site
from tests.workflow.worlds import bowl, height


def test_a_path_is_found_and_runs_from_its_release() -> None:
    records = bowl()
    path = find_path(records, "B")
    profile = find_profile(records, path)
    assert path_site(path, profile).release_x[0] == 0.0
    lower = Path("B", release_elevation_m=800.0)
    release = path_site(lower, profile).release_x[0]
    assert height(release) == pytest.approx(800.0, abs=1.0)


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
