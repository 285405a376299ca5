"""Frequency of volumes from the records of the twin."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from avahazard.hazard.volume_source import VolumeSource
from avahazard.records.errors import AvahazardError
from avahazard.store import upkeep
from avahazard.workflow.database import import_files
from avahazard.workflow.hazard import volumes
from avahazard.workflow.requests import VolumesRequest
from tests.workflow.twin import DATA, twin_records

Write = Callable[[str, str], Path]


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> str:
    file = str(tmp_path_factory.mktemp("volumes") / "twin.db")
    upkeep.create(file)
    import_files(file, [DATA])
    return file


def test_every_path_has_its_levels_and_its_records(twin: str, tmp_path: Path) -> None:
    found = volumes(twin, VolumesRequest(plot=tmp_path / "levels.png"))
    entries = found.rows
    assert found.notes == ()
    assert [e.path_id for e in entries] == sorted(p.path_id for p in twin_records().paths)
    for entry in entries:
        of_levels = [level.volume_m3 for level in entry.levels]
        assert of_levels == sorted(of_levels)
        for level in entry.levels:
            assert level.q05_m3 < level.volume_m3 < level.q95_m3
            years = entry.last_year - entry.first_year + 1
            assert level.extrapolated is (level.return_period_years > 2 * years)
        ranked = [point.volume_m3 for point in entry.maxima]
        assert ranked == sorted(ranked, reverse=True)
        assert entry.maxima[0].return_period_years == years + 1
    assert (tmp_path / "levels.png").read_bytes()[:4] == b"\x89PNG"


def test_periods_shorter_than_the_time_between_avalanches_have_no_level(twin: str) -> None:
    (entry,) = volumes(twin, VolumesRequest(paths=["scey"], return_periods=[1.5, 100.0])).rows
    assert [level.return_period_years for level in entry.levels] == [100.0]


def test_over_a_threshold(twin: str) -> None:
    source = VolumeSource(family="gpd", threshold_m3=3e4)
    (entry,) = volumes(twin, VolumesRequest(paths=["saint-clement"], source=source)).rows
    assert "generalised Pareto of log volume over 30000 m3 (given)" in entry.method
    (automatic,) = volumes(
        twin, VolumesRequest(paths=["saint-clement"], source=VolumeSource(family="gpd"))
    ).rows
    assert "(the median)" in automatic.method


def test_a_table_of_ones_own(twin: str, write: Write) -> None:
    rows = "path_id,return_period_years,volume_m3\nscey,10,2e4\nscey,100,6e4\n"
    source = VolumeSource(table=write("table.csv", rows))
    found = volumes(twin, VolumesRequest(source=source, return_periods=[10.0, 300.0]))
    (entry,) = found.rows
    assert (entry.path_id, entry.source, entry.n_records) == ("scey", "given", None)
    assert [level.extrapolated for level in entry.levels] == [False, True]
    assert len(found.notes) == 6
    with pytest.raises(AvahazardError, match="no row of path nants"):
        volumes(twin, VolumesRequest(paths=["nants"], source=source))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"return_periods": [1.0]}, "The return period is 1"),
        ({"plot": Path("levels.txt")}, "not the name of a picture"),
    ],
)
def test_what_cannot_be_asked(twin: str, more: dict[str, object], message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        volumes(twin, VolumesRequest(**more))  # type: ignore[arg-type]


def test_an_unknown_path(twin: str) -> None:
    with pytest.raises(AvahazardError, match="no path 'everest'"):
        volumes(twin, VolumesRequest(paths=["everest"]))
