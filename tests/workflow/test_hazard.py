"""Bounds by stored models, from the records of a database."""

from __future__ import annotations

import csv
import shutil
from collections import Counter
from collections.abc import Callable
from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.effects.site import Site
from avahazard.hazard import future_events
from avahazard.hazard.volume_source import VolumeSource
from avahazard.physics.cells import Cells
from avahazard.physics.runout_curve import RunoutCurve
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.errors import AvahazardError
from avahazard.report.hazard_tables import write_hazard
from avahazard.report.html.content import path_view
from avahazard.report.plots import draw_paths
from avahazard.results.base import Rows, plain
from avahazard.results.hazard import HazardRow, Spread
from avahazard.store.results import AVERAGE, BOUNDS, latest_documents
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.hazard import hazard, zones
from avahazard.workflow.requests import CalibrateRequest, HazardRequest, ImportRequest, ZonesRequest
from avahazard.workflow.stored import load_stored
from tests.workflow.twin import twin_records

Write = Callable[[str, str], Path]


@pytest.fixture(scope="module")
def models(twin_database: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The twin with a model by each of the paper's samplers, and one without volume."""
    file = str(shutil.copy(twin_database, tmp_path_factory.mktemp("hazard") / "models.db"))
    calibrate(file, "gibbs", CalibrateRequest(method="gibbs", draws=500))
    calibrate(file, "metropolis", CalibrateRequest(method="metropolis", draws=500))
    calibrate(file, "constant", CalibrateRequest(law="constant", method="gibbs", draws=500))
    return file


@pytest.fixture
def selected(models: str, tmp_path: Path) -> str:
    return str(shutil.copy(models, tmp_path / "mine.db"))


def rows_of(database: str, name: str, **more: Any) -> Rows[HazardRow]:
    return hazard(database, name, HazardRequest(**more)).rows


def test_hundred_years_for_every_path_by_default(selected: str) -> None:
    rows = rows_of(selected, "gibbs")
    assert [row.path_id for row in rows] == sorted(p.path_id for p in twin_records().paths)
    assert {row.return_period_years for row in rows} == {100.0}
    for row in rows:
        assert row.volume_interval_m3.q05 < row.volume_m3 < row.volume_interval_m3.q95
        x = row.runout_x_m
        # Of the shortest record, 1933 to 1962, some avalanches may pass the end of the profile.
        assert x.q05 < x.q50 < (np.inf if x.q95 is None else x.q95)
        assert "observed_from to observed_to" in row.volume_method
        check_apart(row)
        middle = row.reach.p_per_year.q50
        assert (np.diff(middle) <= 0.0).all()
        # The chance falls to 1 % where the runout of 100 years is.
        crossing = np.interp(-0.01, -np.array(middle), row.reach.x_m)
        middle = row.design.runout_x_m.q50
        if middle is not None:
            assert crossing == pytest.approx(middle, abs=60.0)
    with reading(selected) as session:
        assert latest_documents(session, BOUNDS, "gibbs") == plain(rows, keyed=True)


def check_apart(row: HazardRow) -> None:
    """Each part of what varies is narrower than all of it."""
    whole, natural = row.runout_x_m, row.natural.runout_x_m
    assert natural.q50 == pytest.approx(whole.q50, rel=0.03)
    parameters = row.parameters.runout_x_m
    if whole.q95 is not None and parameters.q95 is not None:
        width = whole.q95 - whole.q05
        assert 0.5 * width < natural.q95 - natural.q05 < 1.05 * width
        assert 0.0 < parameters.q95 - parameters.q05 < width
    assert "all parameters" in row.natural.interval
    assert "error of the rate" in row.design.interval


def test_periods_and_volumes_give_rows_for_both(selected: str) -> None:
    rows = rows_of(selected, "gibbs", return_periods=[30.0], volumes=[1e4, 1e4], paths=["scey"])
    assert [(row.return_period_years, row.volume_m3) for row in rows][1:] == [(None, 1e4)]
    assert rows[0].return_period_years == 30.0
    assert "fixed: the volume of the return period" in rows[0].interval
    assert rows[1].interval.endswith("fixed: the volume")


def test_tables_and_profiles_are_made_once_for_a_path(
    selected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted: Counter[str] = Counter()
    table, smooth = Site.table, future_events.smooth_profile

    def count_table(site: Site, cells: Cells) -> RunoutCurve:
        counted[f"table of {site.path.path_id}"] += 1
        return table(site, cells)

    def count_profile(x: np.ndarray, y: np.ndarray, sigma: np.ndarray | None) -> SmoothProfile:
        counted[f"profile {x[-1]} {y[0]}"] += 1
        return smooth(x, y, sigma)

    monkeypatch.setattr(Site, "table", count_table)
    monkeypatch.setattr(future_events, "smooth_profile", count_profile)
    paths = ["nants", "scey"]
    hazard(
        selected,
        "gibbs",
        HazardRequest(return_periods=[30.0, 100.0], volumes=[1e4, 1e5], paths=paths),
    )
    tables = {f"table of {path_id}" for path_id in paths}
    # The model stands on all paths; it needs the ground of those that it is applied to.
    assert {name for name in counted if name.startswith("table")} == tables
    assert len(counted) == 2 * len(paths)
    assert set(counted.values()) == {1}
    counted.clear()
    zones(selected, "gibbs", ZonesRequest(no_drag=True, return_periods=[10.0], paths=paths))
    assert len(counted) == 2 * len(paths)
    assert set(counted.values()) == {1}


def test_larger_volumes_and_longer_periods_go_further(selected: str) -> None:
    volumes = rows_of(selected, "gibbs", volumes=[1e4, 1e6], paths=["saint-clement"])
    assert volumes[1].runout_x_m.q50 > volumes[0].runout_x_m.q50 + 100.0
    periods = rows_of(selected, "gibbs", return_periods=[10.0, 100.0], paths=["saint-clement"])
    assert periods[1].volume_m3 > periods[0].volume_m3


def test_a_row_does_not_hang_on_the_others(selected: str) -> None:
    alone = rows_of(selected, "gibbs", volumes=[2e4], paths=["nants"])[0]
    among = rows_of(selected, "gibbs", volumes=[1e4, 2e4])
    assert alone in among
    assert alone not in rows_of(selected, "gibbs", volumes=[2e4], paths=["nants"], seed=1)


def test_the_metropolis_model_scatters_in_metres(selected: str) -> None:
    (row,) = rows_of(selected, "metropolis", volumes=[3e4], paths=["saugy"])
    assert "sigma metres of elevation" in row.interval
    z = row.runout_elevation_m
    sigma = load_stored(selected, "metropolis")[0].calibration.parameters["sigma"].mean
    assert z.q95 - z.q05 == pytest.approx(2 * 1.645 * sigma, rel=0.1)


def test_a_model_without_volume_says_so_and_needs_none(selected: str) -> None:
    found = hazard(
        selected,
        "constant",
        HazardRequest(return_periods=[100.0], volumes=[1e3, 1e6], paths=["scey"]),
    )
    rows, notes = found.rows, found.notes
    medians = [row.runout_x_m.q50 for row in rows]
    assert medians == pytest.approx([medians[0]] * 3, rel=0.01)
    assert any("same for every volume" in note for note in notes)
    assert "does not matter" in rows[0].interval


def test_a_volume_beyond_the_records_is_told_with_its_rows(selected: str) -> None:
    found = hazard(selected, "gibbs", HazardRequest(volumes=[1e4, 1e8], paths=["scey", "saugy"]))
    for row in found.rows:
        told = " ".join(row.notes)
        assert ("times the largest recorded on this path" in told) == (row.volume_m3 == 1e8)
        assert ("FRICTION OUT OF BOUNDS" in told) == (row.volume_m3 == 1e8)
        assert row.path_id not in told
    (beyond,) = (n for n in found.notes if "times the largest" in n and n.startswith("scey: "))
    assert beyond.removeprefix("scey: ") in {n for row in found.rows for n in row.notes}


def test_paths_without_volumes_are_left_out_or_refused(selected: str, write: Write) -> None:
    write("paths.csv", "path_id\nbare\n")
    rows = "\n".join(f"bare,{x},{800 + 1200 * exp(-x / 1000):.2f}" for x in range(0, 6001, 30))
    write("events.csv", "event_id,path_id,runout_x_m,date\nb1,bare,1500,1950\nb2,bare,1600,1960\n")
    import_files(selected, [write("profiles.csv", f"path_id,x_m,y_m\n{rows}\n").parent])
    with pytest.raises(AvahazardError, match="path bare"):
        hazard(selected, "gibbs", HazardRequest(paths=["bare"]))
    found = hazard(selected, "gibbs", HazardRequest())
    assert "bare" not in {row.path_id for row in found.rows}
    assert any("left out: No dated event of path bare" in note for note in found.notes)
    assert any("records have changed" in note for note in found.notes)
    assert rows_of(selected, "gibbs", volumes=[1e4], paths=["bare"])[0].runout_x_m.mean > 0
    (any_volume,) = rows_of(selected, "constant", paths=["bare"])
    assert (any_volume.volume_m3, any_volume.return_period_years) == (None, 100.0)
    assert any_volume.design.runout_x_m.q50 > 0.0


def test_a_block_that_does_not_start_is_told_and_given_no_bounds(
    selected: str, write: Write
) -> None:
    write("paths.csv", "path_id\nshelf\n")
    points = [(x, 2000 - 0.1 * x if x <= 300 else 2240 - 0.9 * x) for x in range(0, 1801, 30)]
    rows = "\n".join(f"shelf,{x},{y:.1f}" for x, y in points)
    import_files(selected, [write("profiles.csv", f"path_id,x_m,y_m\n{rows}\n").parent])
    found = hazard(selected, "gibbs", HazardRequest(volumes=[1e4], paths=["shelf"]))
    (row,) = found.rows
    assert row.p_not_released > 0.9
    assert row.runout_x_m == Spread(None, None, None, None)
    assert any("shelf: the block does not start" in note for note in found.notes)


def test_volumes_of_a_table_by_both_ways(selected: str, write: Write) -> None:
    text = "path_id,return_period_years,volume_m3\nscey,30,20000\n"
    source = VolumeSource(table=write("table.csv", text))
    found = hazard(selected, "gibbs", HazardRequest(return_periods=[30.0, 300.0], source=source))
    rows, notes = found.rows, found.notes
    assert [row.path_id for row in rows] == ["scey"] * 2
    assert [row.extrapolated for row in rows] == [False, True]
    assert "past the ends of the table" in " ".join(notes)
    assert rows[0].n_records is None
    assert rows[0].volume_m3 == pytest.approx(2e4)
    # One volume each 30 years: the farthest of 30 years is a common avalanche, of 300 a rare one.
    assert rows[0].design.runout_x_m.q50 < rows[0].runout_x_m.q05
    assert rows[1].design.runout_x_m.q50 > rows[1].runout_x_m.q50


def test_gaps_raise_the_rate(selected: str, write: Write) -> None:
    (before,) = rows_of(selected, "gibbs", paths=["nants"])
    first, last = before.first_year, before.last_year
    text = "path_id,observed_from,observed_to,not_observed\n"
    text += f"nants,{first},{last},{first - 5}-{first + 40}\n"
    import_files(selected, [write("paths.csv", text)], ImportRequest(update=True))
    (after,) = rows_of(selected, "gibbs", paths=["nants"])
    assert after.years_not_observed == 41
    years = last - first + 1 - 41
    assert after.events_per_year == pytest.approx(after.n_records / years)
    assert "41 winters not observed" in after.volume_method


@pytest.mark.parametrize("model", ["gibbs", "constant"])
def test_the_rate_of_a_year_is_a_stated_choice(selected: str, model: str) -> None:
    found = {}
    for year in (1900, None, 2000):
        source = VolumeSource(as_of=year)
        found[year] = hazard(selected, model, HazardRequest(paths=["scey"], source=source))
    shares = [float(np.mean(found[y].rows[0].reach.p_per_year.q50)) for y in (1900, None, 2000)]
    assert len(set(shares)) == 3
    assert not any("--as-of:" in note for note in found[None].notes)
    assert any("the rate is that of 2000, by --as-of" in note for note in found[2000].notes)
    if model == "gibbs":
        assert found[2000].rows[0].volume_method.endswith("; as of 2000")


def test_events_rarer_than_the_period_are_an_error(selected: str) -> None:
    with pytest.raises(AvahazardError, match="2 years") as caught:
        hazard(selected, "gibbs", HazardRequest(return_periods=[2.0]))
    assert "over" in caught.value.hint


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"return_periods": [1.0]}, "The return period is 1"),
        ({"volumes": [-3.0]}, "The volume is -3"),
        ({"volumes": [float("nan")]}, "The volume is nan"),
        ({"paths": ["everest"]}, "no path 'everest'"),
    ],
)
def test_what_cannot_be_asked(selected: str, more: dict[str, Any], message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        hazard(selected, "gibbs", HazardRequest(**more))


def test_no_such_model(selected: str) -> None:
    with pytest.raises(AvahazardError, match="no model nobody"):
        hazard(selected, "nobody", HazardRequest())


def test_bounds_as_a_file_and_a_picture(selected: str, tmp_path: Path) -> None:
    rows = rows_of(selected, "gibbs", return_periods=[100.0, 1e4], paths=["saint-clement"])
    assert rows[1].runout_x_m.q95 is None
    write_hazard(tmp_path / "bounds.csv", rows)
    with (tmp_path / "bounds.csv").open(encoding="utf-8") as handle:
        found = list(csv.DictReader(handle))
    assert [line["path_id"] for line in found] == ["saint-clement"] * 2
    assert float(found[0]["runout_x_q50_m"]) == pytest.approx(rows[0].runout_x_m.q50)
    assert found[1]["runout_x_q95_m"] == ""
    views = [path_view(twin_records(), row.path_id, rows=[row]) for row in rows]
    draw_paths(tmp_path / "bounds.png", "twin", views)
    assert (tmp_path / "bounds.png").read_bytes()[:4] == b"\x89PNG"


def test_several_models_are_averaged_by_their_weights(selected: str) -> None:
    names, asked = ("gibbs", "constant"), HazardRequest(paths=["saint-clement"])
    found = hazard(selected, names, asked)
    (row,) = found.rows
    weights = {one.model: one.weight for one in row.by_model}
    assert tuple(weights) == names
    assert sum(weights.values()) == pytest.approx(1.0)
    alone = [hazard(selected, name, asked).rows[0].design.runout_x_m.q50 for name in names]
    assert [one.runout_x_m.q50 for one in row.by_model] == alone
    assert min(alone) <= row.design.runout_x_m.q50 <= max(alone)
    assert f"gibbs {weights['gibbs']:.2f}, constant" in found.notes[0]
    # Kept with the first, apart from its own.
    with reading(selected) as session:
        assert latest_documents(session, AVERAGE, "gibbs") == plain(found.rows, keyed=True)
        assert latest_documents(session, BOUNDS, "gibbs")[0].get("by_model") is None


def test_models_of_other_records_are_not_averaged(selected: str) -> None:
    calibrate(selected, "few", CalibrateRequest(method="gibbs", draws=500, paths=["nants"]))
    with pytest.raises(AvahazardError, match="few was calibrated on other records than gibbs"):
        hazard(selected, ["gibbs", "few"], HazardRequest())
    with pytest.raises(AvahazardError, match="metropolis"):
        hazard(selected, ["gibbs", "metropolis"], HazardRequest())
