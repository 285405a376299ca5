"""Zones by stored models, from the records of a database."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows, plain
from avahazard.results.hazard import ZonedPath
from avahazard.store.results import ZONES, latest_documents
from avahazard.store.session import reading
from avahazard.store.upkeep import create
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.database import import_files
from avahazard.workflow.hazard import NoDragError, hazard, load_limits, zones
from avahazard.workflow.requests import CalibrateRequest, HazardRequest, SynthRequest, ZonesRequest
from avahazard.workflow.synth import synthesise

Write = Callable[[str, str], Path]
OWN = """
[[zone]]
name = "strong"
color = "#aa0000"
rule = [{ return_period_years = 50, pressure_kpa_min = 100 }]
[[zone]]
name = "reached"
color = "#00aa00"
rule = [{ return_period_years = 50 }]
"""


@pytest.fixture(scope="module")
def models(twin_database: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The twin with a model, one without volume, and one that scatters in metres."""
    file = str(shutil.copy(twin_database, tmp_path_factory.mktemp("zones") / "models.db"))
    calibrate(file, "gibbs", CalibrateRequest(method="gibbs", draws=200, chains=2))
    calibrate(
        file, "constant", CalibrateRequest(law="constant", method="gibbs", draws=200, chains=2)
    )
    calibrate(
        file, "metres", CalibrateRequest(method="metropolis", draws=60, chains=2, paths=["scey"])
    )
    return file


@pytest.fixture
def selected(models: str, tmp_path: Path) -> str:
    return str(shutil.copy(models, tmp_path / "mine.db"))


def median(entry: ZonedPath, period: float, what: str) -> np.ndarray:
    """Medians of speed or pressure at the places of an entry."""
    (k,) = (
        k
        for k, found in enumerate(entry.places[0].by_return_period)
        if found.return_period_years == period
    )
    return np.array([getattr(p.by_return_period[k], what).q50 for p in entry.places])


@dataclass(frozen=True)
class Found:
    """What one call found, its database, its picture."""

    database: str
    entries: Rows[ZonedPath]
    notes: tuple[str, ...]
    picture: str


@pytest.fixture(scope="module")
def french(models: str, tmp_path_factory: pytest.TempPathFactory) -> Found:
    folder = tmp_path_factory.mktemp("french")
    file = str(shutil.copy(models, folder / "found.db"))
    found = zones(
        file,
        "gibbs",
        ZonesRequest(
            no_drag=True,
            limits="french",
            paths=["scey", "saugy"],
            return_periods=[10.0],
            plot=folder / "zones.svg",
        ),
    )
    return Found(file, found.rows, found.notes, (folder / "zones.svg").read_text())


def test_an_entry_for_each_path_stored_with_its_model(french: Found) -> None:
    with reading(french.database) as session:
        assert latest_documents(session, ZONES, "gibbs") == plain(french.entries, keyed=True)
    assert french.picture.count("<!-- zone: yellow -->") == len(french.entries)
    assert [e.path_id for e in french.entries] == ["saugy", "scey"]
    assert any("no drag" in note for note in french.notes)
    # What is said of the model and of the limits goes with the entry of each path too.
    for entry in french.entries:
        assert any("no drag" in note for note in entry.notes)
        assert set(entry.notes) <= set(french.notes)
    assert any("saugy: T = 300 is past twice the observed years" in note for note in french.notes)
    assert [z.extrapolated for z in french.entries[0].zones] == [False, False, True]
    for entry in french.entries:
        ten, hundred, rare = (median(entry, t, "speed_m_s") for t in (10.0, 100.0, 300.0))
        assert (ten <= hundred).all()
        assert (hundred <= rare).all()
        assert ten[0] == 0.0
        assert entry.p_not_released < 0.01
        assert rare.max() > 40.0
        assert median(entry, 100.0, "pressure_kpa").max() == pytest.approx(
            0.3 * hundred.max() ** 2, rel=0.05
        )
        chance = [place.p_reach_per_year for place in entry.places]
        assert chance == sorted(chance, reverse=True)
        assert [z.zone for z in entry.zones] == ["red", "blue", "yellow"]
        ends = [entry.release_x_m, *(z.to_x_m for z in entry.zones)]
        assert [z.from_x_m for z in entry.zones] == ends[:-1]
        assert ends == sorted(ends)


def test_zones_end_where_hazard_says_that_runouts_do(french: Found) -> None:
    rows = hazard(
        french.database, "gibbs", HazardRequest(return_periods=[100.0, 300.0], paths=["scey"])
    ).rows
    for zone, row in zip(french.entries[1].zones[1:], rows, strict=True):
        x = row.design.runout_x_m
        assert (zone.to_x_q05_m, zone.to_x_m) == pytest.approx((x.q05, x.q50), abs=0.01)
    found = {d.return_period_years: d.design for d in french.entries[1].designs}
    for row in rows:
        here = found[row.return_period_years]
        assert here.runout_x_m.q50 == pytest.approx(row.design.runout_x_m.q50, abs=0.01)
        assert here.records_beyond == row.design.records_beyond


def test_a_path_does_not_hang_on_the_others(french: Found, selected: str) -> None:
    alone = zones(
        selected,
        "gibbs",
        ZonesRequest(no_drag=True, limits="french", paths=["scey"], return_periods=[10.0]),
    ).rows
    assert alone == french.entries[1:]


def test_limits_and_density_of_ones_own(selected: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(OWN)
    own = str(tmp_path / "own.toml")
    (entry,) = zones(
        selected,
        "gibbs",
        ZonesRequest(no_drag=True, limits=own, paths=["scey"], density=150.0, density_sd=0.0),
    ).rows
    assert entry.limits == "own.toml"
    strong, reached = entry.zones
    assert (strong.zone, strong.color) == ("strong", "#aa0000")
    x = np.array([place.x_m for place in entry.places])
    pressure = median(entry, 50.0, "pressure_kpa")
    assert pressure == pytest.approx(0.15 * median(entry, 50.0, "speed_m_s") ** 2, rel=0.05)
    # The median of the ends is near the end by the medians.
    assert strong.to_x_m == pytest.approx(x[pressure >= 100.0][-1], abs=2 * (x[1] - x[0]))
    assert reached.to_x_m > strong.to_x_m


def test_a_block_that_does_not_start_is_told(selected: str, write: Write) -> None:
    write("paths.csv", "path_id,observed_from,observed_to\nshelf,1900,2000\n")
    places = [(x, 2000 - 0.1 * x if x <= 300 else 2240 - 0.9 * x) for x in range(0, 1801, 30)]
    points = "\n".join(f"shelf,{x},{y:.1f}" for x, y in places)
    write("events.csv", "event_id,path_id,runout_x_m,date\ns1,shelf,1500,1950\n")
    import_files(selected, [write("profiles.csv", f"path_id,x_m,y_m\n{points}\n").parent])
    found = zones(selected, "constant", ZonesRequest(no_drag=True, paths=["shelf"]))
    (entry,) = found.rows
    assert entry.p_not_released > 0.9
    assert any(
        "shelf: 100% of the avalanches stop at their release" in note for note in found.notes
    )


def test_what_has_no_volumes_is_left_out_or_needs_none(selected: str, write: Write) -> None:
    write("paths.csv", "path_id\nbare\n")
    points = "\n".join(
        f"bare,{x},{2000 - 0.9 * x + 1.4e-4 * x * x:.2f}" for x in range(0, 3001, 30)
    )
    write("events.csv", "event_id,path_id,runout_x_m,date\nb1,bare,1500,1950\nb2,bare,1600,1960\n")
    import_files(selected, [write("profiles.csv", f"path_id,x_m,y_m\n{points}\n").parent])
    with pytest.raises(AvahazardError, match="path bare"):
        zones(selected, "gibbs", ZonesRequest(no_drag=True, paths=["bare"]))
    (entry,) = zones(selected, "constant", ZonesRequest(no_drag=True, paths=["bare"])).rows
    assert entry.zones[0].to_x_m > entry.release_x_m


@pytest.mark.parametrize(
    ("model", "more", "message"),
    [
        ("nobody", {}, "no model nobody"),
        ("metres", {}, "The scatter of metres is in metres"),
        ("gibbs", {"limits": "norwegian"}, "There are no limits 'norwegian'"),
        ("gibbs", {"density": 0.0}, "The density is 0"),
        ("gibbs", {"density_sd": -1.0}, "The standard deviation of the density is -1"),
        ("gibbs", {"return_periods": [1.0]}, "The return period is 1"),
        ("gibbs", {"paths": ["everest"]}, "no path 'everest'"),
        ("gibbs", {"plot": Path("zones.txt")}, "not the name of a picture"),
    ],
)
def test_what_cannot_be_asked(models: str, model: str, more: dict[str, Any], message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        zones(models, model, ZonesRequest(no_drag=True, **more))


def test_speeds_that_nothing_but_friction_limits_are_refused(selected: str) -> None:
    with pytest.raises(NoDragError, match="Nothing but friction limits the speeds") as caught:
        zones(selected, "gibbs", ZonesRequest(paths=["scey"]))
    assert "avahazard add gibbs turbulent-drag --as NEW" in caught.value.hint
    assert "--no-drag" in caught.value.hint
    found = zones(selected, "gibbs", ZonesRequest(no_drag=True, paths=["scey"]))
    assert "no_drag" in [note.key for note in found.notes]


@pytest.mark.parametrize("effects", [pytest.param(("turbulent-drag",), marks=pytest.mark.slow), ()])
def test_drag_or_measured_speeds_limit_speeds(effects: tuple[str, ...], tmp_path: Path) -> None:
    file = str(tmp_path / "d.db")
    create(file)
    synthesise(tmp_path / "world", SynthRequest(events=20, paths=2, seed=1, speeds=0.3))
    if effects:
        (tmp_path / "world" / "velocities.csv").unlink()
    import_files(file, [tmp_path / "world"])
    calibrate(file, "m", CalibrateRequest(with_=effects, draws=50, chains=2))
    found = zones(file, "m", ZonesRequest(paths=["P01"]))
    assert ("no_drag" in [note.key for note in found.notes]) == (not effects)


@pytest.mark.usefixtures("drawn_little")
def test_speeds_that_fail_the_measured_ones_are_noted(tmp_path: Path) -> None:
    file = str(tmp_path / "d.db")
    create(file)
    hidden = SynthRequest(effects=("turbulent-drag",), events=40, paths=3, seed=1, speeds=0.4)
    synthesise(tmp_path / "world", hidden)
    import_files(file, [tmp_path / "world"])
    calibrate(file, "base", CalibrateRequest(draws=50, chains=2))
    keys = [note.key for note in zones(file, "base", ZonesRequest(paths=["P01"])).notes]
    assert "speeds_fail" not in keys
    compare(file, "base")
    found = zones(file, "base", ZonesRequest(paths=["P01"]))
    (note,) = (note for note in found.notes if note.key == "speeds_fail")
    assert note.startswith("the speeds of base differ from the measured ones beyond chance, by +")


def test_a_bad_file_of_limits_is_named(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text("zone = 3\n")
    with pytest.raises(AvahazardError, match=r"own\.toml, zone: .*list"):
        load_limits(str(file))
