"""The twin in `data/` is what its script makes, and what the paper states."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from avahazard.physics.smooth_profile import legendre_profile, smooth_profile
from avahazard.records.collection import data_fingerprint
from avahazard.records.reading import read_records

DATA = Path(__file__).resolve().parents[2] / "data"

# Table 1 of the paper: events, drop in m, smallest and largest volume in m3.
PAPER = {
    "saint-clement": (42, 1850.0, 3e3, 1.2e6),
    "gurraz": (16, 2200.0, 7e3, 3e5),
    "saugy": (19, 1550.0, 1.6e3, 1.58e5),
    "scey": (15, 1090.0, 1e3, 6e4),
    "entremene": (27, 1230.0, 3e3, 4.8e5),
    "nants": (27, 1200.0, 2e3, 2.5e5),
    "grand-chantey": (27, 1100.0, 2e3, 2.7e5),
}


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_twin", DATA / "make_twin.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_script_makes_the_files(script: ModuleType, tmp_path: Path) -> None:
    script.write_twin(tmp_path)
    made, kept = read_records([tmp_path]), read_records([DATA])
    assert made.paths == kept.paths
    assert len(made.events) == len(kept.events)
    for one, two in zip(made.events, kept.events, strict=True):
        assert one.event_id == two.event_id
        assert one.date == two.date
        assert one.volume_m3 == two.volume_m3
        # The last printed digit may hang on the processor.
        if one.runout_elevation_m is None:
            assert two.runout_elevation_m is None
        else:
            assert one.runout_elevation_m == pytest.approx(two.runout_elevation_m, abs=0.011)
    assert {f.name for f in tmp_path.iterdir()} == {
        "paths.csv", "profiles.csv", "events.csv", "truth.json",
    }  # fmt: skip


def test_script_makes_the_same_twice(script: ModuleType) -> None:
    one, two = script.make_twin(), script.make_twin()
    assert data_fingerprint(one[0]) == data_fingerprint(two[0])
    assert one[1] == two[1]


def test_twin_has_the_facts_of_the_paper() -> None:
    records = read_records([DATA])
    assert len(records.events) == 173
    profiles = {p.path_id: p for p in records.profiles}
    for path in records.paths:
        n, drop, low, high = PAPER[path.path_id]
        events = [e for e in records.events if e.path_id == path.path_id]
        volumes = [e.volume_m3 for e in events]
        assert len(events) == n
        assert (min(volumes), max(volumes)) == (low, high)
        y = profiles[path.path_id].y_m
        assert y[0] - y[-1] == pytest.approx(drop, abs=2.0)
        assert "twin" in (path.name or "")
        assert "twin" in (path.location or "")
    assert 0 < sum(e.left_profile for e in records.events) < 6
    years = {p.path_id: (p.observed_from, p.observed_to) for p in records.paths}
    assert (years["gurraz"], years["scey"]) == ((1933, 1962), (1910, 1937))
    for event in records.events:
        first, last = years[event.path_id or ""]
        assert first <= int(str(event.date)[:4]) <= last


def test_dates_brought_into_the_printed_years_keep_their_day_and_order(script: ModuleType) -> None:
    start, end = 1902, 2003
    for winter in range(start + 1, end + 1):
        for day in (f"{winter - 1}-12-01", f"{winter}-02-28", f"{winter}-04-29"):
            event = script.Event("e", path_id="scey", date=day)
            moved = script._in_years(event, {"scey": (start, end)}).date
            assert 1910 <= int(moved[:4]) <= 1937
            assert moved[5:7] == day[5:7]
    ends = [
        script._in_years(script.Event("e", path_id="scey", date=d), {"scey": (start, end)}).date
        for d in (f"{start}-12-01", f"{end}-04-01")
    ]
    assert [d[:4] for d in ends] == ["1910", "1937"]
    other = script.Event("e", path_id="nants", date="1950-01-02")
    assert script._in_years(other, {}) is other


def test_polynomial_of_the_paper_follows_every_profile_within_metres() -> None:
    for profile in read_records([DATA]).profiles:
        polynomial = legendre_profile(profile.x_m, profile.y_m)
        assert polynomial.max_deviation_m < 10.0, profile.path_id
        assert np.all(polynomial.derivatives(profile.x_m)[1] < 0.0)
        # The points are good to a decimetre: the block runs on them.
        smooth = smooth_profile(profile.x_m, profile.y_m)
        assert (smooth.method, smooth.sigma_m) == ("spline", pytest.approx(0.1))
        assert smooth.max_deviation_m < 0.1
        assert np.all(smooth.derivatives(profile.x_m)[1] < 0.0)


def test_true_frictions_give_the_law_back(script: ModuleType) -> None:
    _, truth = script.make_twin()
    volume = np.array([e["volume_m3"] for e in truth["events"]])
    slope, level = np.polyfit(volume, np.log([e["mu"] for e in truth["events"]]), 1)
    assert np.exp(level) == pytest.approx(0.519, rel=0.01)
    assert -slope == pytest.approx(3.36e-7, rel=0.1)
