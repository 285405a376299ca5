"""Synthetic datasets: what is hidden in them, who knows it, and what their tables count."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.study import DOCS, ROOT, lines, with_parts
from benchmarks.worlds import beyond, catalogue, measuring, tables
from benchmarks.worlds.knowing import fair_crps, knowing
from benchmarks.worlds.loop import judge, share_inside


def _rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as text:
        return list(csv.DictReader(text))


def test_a_dataset_is_the_same_for_the_same_seed_and_holds_out_a_quarter(tmp_path: Path) -> None:
    truth = beyond.make("second of the winter + speeds", 3, tmp_path / "one")
    beyond.make("second of the winter + speeds", 3, tmp_path / "two")
    for file in ("events.csv", "held_out/events.csv", "velocities.csv", "truth.json"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()
    train = _rows(tmp_path / "one" / "events.csv")
    out = _rows(tmp_path / "one" / "held_out" / "events.csv")
    assert len(train) + len(out) == beyond.N_EVENTS
    assert 0.2 <= len(out) / beyond.N_EVENTS <= 0.3
    tracks = {row["event_id"] for row in _rows(tmp_path / "one" / "velocities.csv")}
    assert len(tracks) == beyond.N_TRACKS
    assert tracks <= {row["event_id"] for row in train}
    assert truth["right"] == ["covariate:order_in_winter", "covariate:days_since_last"]


def test_datasets_of_the_catalogue_hold_out_winters(tmp_path: Path) -> None:
    truth = catalogue.make("catalogue: centrifugal", 2, tmp_path)
    assert truth == {
        "right": ["centrifugal"], "neutral": ["path-effect"], "without": ["centrifugal"]
    }  # fmt: skip
    train, out = _rows(tmp_path / "events.csv"), _rows(tmp_path / "held_out" / "events.csv")

    def winters(rows: list[dict[str, str]]) -> set[int]:
        return {int(row["date"][:4]) + (row["date"][5:7] >= "10") for row in rows}

    assert not winters(train) & winters(out)
    known = {row["event_id"] for row in train}
    assert {row["event_id"] for row in _rows(tmp_path / "velocities.csv")} <= known


LATER = pytest.mark.slow
"""Further arms, of the same kinds as those before them."""


@pytest.mark.parametrize(
    "arm",
    [
        "wet and large",
        "two kinds",
        pytest.param("force by u", marks=LATER),
        pytest.param("wide in wet snow", marks=LATER),
    ],
)
def test_who_knows_the_form_gains_and_predicts_better(arm: str, tmp_path: Path) -> None:
    beyond.make(arm, 7, tmp_path)
    found = knowing(tmp_path)
    assert found["gain"] > 10.0
    assert found["crps"] < found["base_crps"]


def test_where_nothing_is_hidden_there_is_nothing_to_know(tmp_path: Path) -> None:
    beyond.make("null", 7, tmp_path)
    found = knowing(tmp_path)
    assert found["gain"] == 0.0
    assert found["crps"] == found["base_crps"]


def test_fair_crps_is_that_of_all_pairs_of_draws() -> None:
    draws = np.random.default_rng(1).normal(size=30)
    pairs = np.abs(draws[:, None] - draws).sum() / (30 * 29)
    assert fair_crps(draws, 0.3) == pytest.approx(np.mean(np.abs(draws - 0.3)) - 0.5 * pairs)


def test_the_true_force_is_held_by_a_band_about_it_and_not_by_one_beside_it() -> None:
    x = np.linspace(5.0, 35.0, 7)
    true = 2.0 * x / 30.0
    band = {"of": "speed", "x": x, "q05": true - 0.1, "q95": true + 0.1}
    assert share_inside("force by u", 1, band) == 1.0
    assert share_inside("force by u", 1, {**band, "q05": true + 0.05}) == 0.0
    degrees = np.linspace(20.0, 45.0, 26)
    friction = 0.35 * np.maximum(np.tan(np.radians(degrees)) - 0.3, 0.0)
    friction -= friction.mean()
    band = {"of": "slope", "x": degrees, "q05": friction - 1e-6, "q95": friction + 1e-6}
    assert share_inside("force by slope + speeds", 1, band) == 1.0
    assert share_inside("two kinds", 1, band) is None


def _line(name: str, rounds: list[list[str]], **others: Any) -> dict[str, Any]:
    right = others.pop("right", ["interaction:snow_type*volume"])
    told = [["", names, 10.0] for names in rounds]
    line = {"name": name, "right": right, "neutral": ["snow-type"], "rounds": told}
    return line | {"crps": [100.0, 80.0], "gain": 20.0, "knows": 75.0} | others


def test_keys_count_in_any_order_and_what_is_harmless_is_not_false() -> None:
    line = _line("a #1", [["snow-type"], ["interaction:volume_m3*snow_type"], ["season"]])
    assert tables.in_set(line)
    assert tables.alone(line)
    assert not tables.false(line, 0)
    assert tables.false_later(line)
    assert tables.wrong_alone(line)
    both = _line("a #2", [["season", "interaction:volume_m3*snow_type"]])
    assert tables.in_set(both)
    assert not tables.alone(both)
    assert not tables.false_at_all(both)
    assert tables.closed([line, _line("a #3", [[]], knows=97.0)]) == [0.8]


def test_intervals_are_wilsons() -> None:
    assert tables.wilson(0, 20) == (pytest.approx(0.0, abs=1e-12), pytest.approx(0.1611, abs=1e-4))
    assert tables.wilson(16, 20) == (
        pytest.approx(0.5840, abs=1e-4),
        pytest.approx(0.9193, abs=1e-4),
    )


def test_tables_name_every_arm_and_what_went_wrong() -> None:
    lines = [
        _line("wet and large #1", [["interaction:snow_type*volume_m3"]], inside=None),
        _line("wet and large #2", [["season"], []], error="round 3: no"),
        _line("catalogue: season #2", [["season"]], right=["season"]),
        {**_line("null #1", [["two-kinds"]]), "right": [], "neutral": []},
    ]
    made = tables.parts(lines)
    assert "right kind in the set | 1/2 = 50 % (9 to 91) | ≥ 80 % |" in made["targets"]
    assert "in any round | 1/1 = 100 % (21 to 100) |" in made["targets"]
    assert "| wet and large | 2 | 20 | 1/2 = 50 % |" in made["effects"]
    assert "| null | 1 | 1/1 = 100 %" in made["nulls"]
    assert "- wet and large #2 (gain 20): `season`; ; round 3: no" in made["failures"]
    json.dumps(lines)


def test_the_page_is_written_from_the_results() -> None:
    text = (DOCS / "worlds.md").read_text(encoding="utf-8")
    files = re.findall(r"worlds.py table (\S+) --page docs/worlds.md", text)
    assert len(files) == 2
    for file in files:
        made = (measuring if "measuring" in file else tables).parts(lines(ROOT / file))
        assert with_parts(text, made) == text


def test_a_speed_to_be_measured_is_the_true_one_with_its_error(tmp_path: Path) -> None:
    truth = beyond.make("force by u + speeds", 3, tmp_path)
    truths = measuring.Truth("force by u", 3, truth)
    events = {row["event_id"]: row for row in _rows(tmp_path / "events.csv")}
    off = []
    for track in _rows(tmp_path / "velocities.csv")[4:200:9]:
        event, x = events[track["event_id"]], float(track["x_m"])
        found = truths.measured(event, x)
        assert found is not None
        off.append(found["speed_m_s"] - float(track["speed_m_s"]))
        stop = truths.stop[truths.number[event["event_id"]]]
        assert truths.measured(event, stop + 1.0) is None
        half = truths.measured(event, None)
        assert half is not None
        assert half["x_m"] < stop
    # Either has an error of 1 to 2 m/s.
    assert 1.0 < np.std(off) < 4.0
    assert abs(np.mean(off)) < 2.0


@pytest.mark.slow
def test_the_loop_finds_what_no_name_fits_and_the_error_falls() -> None:
    line = judge("wet and large #1")
    assert tables.alone(line)
    assert "error" not in line
    assert tables.closed([line])[0] > 0.4
