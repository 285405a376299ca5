"""Every effect, in the dataset's records."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.synth.dataset import Settings
from avahazard.synth.effects import CATALOGUE, find_effect
from tests.synth.datasets import dataset, residuals, truth_column
from tests.synth.oracle import gain

KEYS = (*CATALOGUE, "covariate:snow_temperature_c")
IN_THE_BASE = {"centrifugal"}
SMALL = {"n_events": 120, "n_paths": 6, "settings": Settings(speeds=0.2)}


@pytest.mark.parametrize("key", sorted(set(KEYS) - IN_THE_BASE))
def test_strength_nought_is_the_base_world(key: str) -> None:
    base, _ = dataset(2, **SMALL)
    neutral, _ = dataset(2, effects={key: 0.0}, **SMALL)
    assert neutral.events == base.events
    assert neutral.speeds == base.speeds
    assert neutral.paths == base.paths


def test_centrifugal_is_in_the_base_world() -> None:
    base, truth = dataset(2, **SMALL)
    assert dataset(2, effects={"centrifugal": 1.0}, **SMALL)[0].events == base.events
    _, without = dataset(2, effects={"centrifugal": 0.0}, **SMALL)
    # Curvature loads a concave path: without it the block runs further.
    further = truth_column(without, "stop_x_m") - truth_column(truth, "stop_x_m")
    assert np.mean(further) > 30.0


@pytest.mark.parametrize("key", KEYS)
def test_truth_tells_each_effect(key: str) -> None:
    _, truth = dataset(2, effects={key: 1.0}, **SMALL)
    assert truth["effects"][key]["strength"] == 1.0
    assert truth["effects"][key]["parameters"]
    assert len(truth["events"]) == 120


@pytest.mark.parametrize("key", ["turbulent-drag", "cohesion", "entrainment", "forest-drag"])
def test_resistance_shortens_the_run_at_the_same_friction(key: str) -> None:
    _, base = dataset(2, **SMALL)
    _, truth = dataset(2, effects={key: 1.0}, **SMALL)
    shift = truth["effects"][key]["parameters"].get("log_mu", 0.0)
    kept = {e["event_id"]: e for e in base["events"]}
    same = [
        (kept[e["event_id"]]["stop_x_m"], e["stop_x_m"])
        for e in truth["events"]
        if e["mu"] == pytest.approx(kept[e["event_id"]]["mu"] * np.exp(shift))
    ]
    before, after = np.array(same).T
    assert len(before) > 60
    if shift == 0.0:
        assert (after <= before + 1e-9).all()
    assert np.mean(after - before) < -10.0


def test_effects_on_friction_have_the_size_they_tell() -> None:
    keys = ("snow-type", "path-section", "season", "release-elevation")
    records, truth = dataset(4, n_events=300, effects=dict.fromkeys(keys, 1.0))
    told = {key: truth["effects"][key]["parameters"] for key in keys}
    section = {p.path_id: p.section for p in records.paths}
    winter_day = []
    for e in records.events:
        assert e.date is not None
        month = np.datetime64(e.date)
        first = np.datetime64(f"{int(e.date[:4]) - (0 if e.date[5:7] == '12' else 1)}-12-01")
        winter_day.append((month - first).astype(int))
    expected = (
        np.array([told["snow-type"]["log_mu"][e.covariates["snow_type"]] for e in records.events])
        + np.array([told["path-section"]["log_mu"][section[e.path_id]] for e in records.events])
        + told["season"]["log_mu_over_winter"] * (np.array(winter_day) / 150.0 - 0.5)
        + told["release-elevation"]["log_mu_per_m"]
        * (np.array([e.release_elevation_m for e in records.events]) - 2200.0)
    )
    law = np.log(0.5) - 7e-7 * truth_column(truth, "volume_m3")
    np.testing.assert_allclose(np.log(truth_column(truth, "mu_median")), law + expected, atol=1e-9)


def test_scatter_falls_with_volume() -> None:
    _, truth = dataset(4, n_events=1500, effects={"volume-scatter": 1.0})
    volume = truth_column(truth, "volume_m3")
    apart = np.log(truth_column(truth, "mu") / truth_column(truth, "mu_median"))
    small, large = apart[volume < 3e4].std(), apart[volume > 2e5].std()
    assert small > 2.5 * large
    assert residuals(truth).std() == pytest.approx(1.0, abs=0.06)


def test_path_effect_has_its_spread() -> None:
    _, truth = dataset(4, n_events=600, n_paths=60, effects={"path-effect": 1.0})
    offsets = list(truth["effects"]["path-effect"]["parameters"]["log_mu"].values())
    assert np.std(offsets) == pytest.approx(0.15, rel=0.25)


def test_observation_limit_is_kept_but_not_told() -> None:
    records, truth = dataset(4, effects={"observation-limit": 1.0})
    assert all(p.observed_below_m is None for p in records.paths)
    limit = truth["seen_below_m"]
    y = truth_column(truth, "front_elevation_m")
    assert all(v <= limit[e.path_id] for v, e in zip(y, records.events, strict=True))


def test_old_records_lie_too_high() -> None:
    records, truth = dataset(4, n_events=2000, effects={"epoch-bias": 1.0})
    y = truth_column(truth, "front_elevation_m")
    old, new = [], []
    for e, v in zip(records.events, y, strict=True):
        if e.runout_elevation_m is not None and e.year is not None:
            (old if e.year < 1950 else new).append(e.runout_elevation_m - v)
    assert np.mean(old) == pytest.approx(50.0, abs=2.5)
    assert np.mean(new) == pytest.approx(0.0, abs=2.0)


def test_front_is_ahead_by_a_share_of_the_deposit() -> None:
    records, truth = dataset(4, n_events=200, effects={"leading-edge": 1.0})
    length = np.array([e.deposit_length_m for e in records.events])
    lead = truth_column(truth, "front_x_m") - truth_column(truth, "stop_x_m")
    stopped = truth_column(truth, "status") == "stopped"
    # Along the path it is a little more than in x.
    ratio = (lead / length)[stopped]
    assert (ratio <= 0.6 + 1e-3).all()
    assert np.median(ratio) > 0.55


def test_covariate_makes_its_column_and_bends() -> None:
    records, truth = dataset(4, n_events=300, effects={"covariate:new_snow": 1.0})
    z = np.array([e.covariates["new_snow"] for e in records.events], float)
    extra = np.log(truth_column(truth, "mu_median") / 0.5) + 7e-7 * truth_column(truth, "volume_m3")
    straight = np.polynomial.Polynomial.fit(z, extra, 1)(z)
    assert np.std(extra) == pytest.approx(0.1, abs=0.025)
    assert np.std(extra - straight) > 0.03


def test_unknown_effects_are_refused() -> None:
    with pytest.raises(AvahazardError, match="no effect 'gravity'"):
        find_effect("gravity")
    with pytest.raises(AvahazardError, match="no effect 'covariate:'"):
        find_effect("covariate:")
    with pytest.raises(AvahazardError, match="not numeric"):
        dataset(1, effects={"covariate:snow_type": 1.0})


@pytest.mark.slow
@pytest.mark.parametrize("key", [*CATALOGUE, "covariate:new_snow_cm"])
def test_gain_is_clearly_over_ten_nats(key: str) -> None:
    assert gain(101, key) > 12.0
