"""The view of one path, and one run down it, of a friction and by a stored model."""

from __future__ import annotations

import shutil
from pathlib import Path as FilePath

import numpy as np
import pytest

from avahazard.effects.site import Site, path_site
from avahazard.inference.model.laws import LAWS
from avahazard.physics.cells import no_resistance
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile, Records
from avahazard.records.errors import AvahazardError
from avahazard.report.plots import with_gaps
from avahazard.results.terrain import PathCheck, Runout, SpeedHere, Stretch
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.path import (
    describe_path,
    run_block,
    run_site,
    stretches,
    view_path,
    with_table,
)
from avahazard.workflow.requests import RunoutRequest
from avahazard.workflow.stored import load_stored
from tests.workflow.worlds import bowl, height, smooth_bowl, stop_x


def _describe(records):
    profile = records.profiles[0]
    smooth = smooth_profile(profile.x_m, profile.y_m)
    return describe_path(records.paths[0], profile, smooth, list(records.events))


def _of_points(x, y, sigma: float | None = None) -> PathCheck:
    given = None if sigma is None else np.full(len(x), sigma)
    profile = Profile("B", x, y, elevation_sigma_m=given)
    return describe_path(Path("B"), profile, smooth_profile(x, y, given), [])


def test_a_bowl_that_falls_all_the_way() -> None:
    document = _describe(bowl(1900.0))
    assert document.fit.method == "spline"
    assert document.fit.rms_m < document.fit.elevation_sigma_m == pytest.approx(0.1)
    assert document.monotone is True
    assert document.rises == document.notes == ()
    assert (document.length_m, document.n_points) == (1900.0, 96)
    assert document.drop_m == pytest.approx(798.0)


def test_where_it_rises_and_how_sharply_it_bends() -> None:
    document = _describe(bowl(2400.0))
    assert document.monotone is False
    (rise,) = document.rises
    assert rise.from_x_m == pytest.approx(2000.0, abs=10.0)
    assert rise.to_x_m == 2400.0
    assert document.min_curvature_radius_m == pytest.approx(2500.0, rel=0.05)
    assert "rises at x = " in document.notes[0]


def test_a_flow_longer_than_the_radius_is_told() -> None:
    flow = tuple(Event(str(n), "B", runout_x_m=9.0, deposit_length_m=n) for n in (10, 2700, 9000))
    document = _describe(bowl(2400.0, flow))
    assert document.flow_length_m == 2700.0
    (bend,) = document.sharp_bends
    # (1 + f'²)^1.5 = 2700 / 2500 at both ends.
    half_width = np.sqrt((2700.0 / 2500.0) ** (2.0 / 3.0) - 1.0) / 4e-4
    assert bend.from_x_m == pytest.approx(2000.0 - half_width, abs=15.0)
    assert "below the length of the flow (2700 m)" in document.notes[1]


def test_a_step_is_felt_as_the_block_feels_it() -> None:
    x = np.linspace(0.0, 2000.0, 101)
    y = 1000.0 - 0.4 * x - 60.0 * np.tanh((x - 1000.0) / 30.0)
    fit = _of_points(x, y).fit
    assert (fit.method, fit.degree, fit.sigma_from) == ("spline", None, "estimated")
    assert fit.polynomial_rms_m > 5.0
    # A cliff shorter than the block is rounded off.
    assert fit.elevation_sigma_m < fit.rms_m < 2.0 < fit.max_deviation_m < 10.0
    assert fit.block_m == 100.0


def test_noise_is_told_from_ground() -> None:
    x = np.linspace(0.0, 1900.0, 191)
    y = height(x) + np.random.default_rng(1).normal(0.0, 4.0, 191)
    check = _of_points(x, y)
    assert check.fit.elevation_sigma_m == pytest.approx(4.0, rel=0.15)
    assert check.fit.rms_m == pytest.approx(check.fit.elevation_sigma_m, rel=0.1)
    assert check.fit.ground_sd_m is not None
    assert 0.3 < check.fit.ground_sd_m < 2.0
    assert check.notes == ()


def test_a_stated_error_that_the_points_contradict_is_told() -> None:
    x = np.linspace(0.0, 1900.0, 191)
    y = height(x) + np.random.default_rng(1).normal(0.0, 4.0, 191)
    assert "scatter by" in _of_points(x, y, 1.0).notes[0]
    assert not any("scatter by" in note for note in _of_points(x, y, 4.0).notes)


def test_few_points_are_told() -> None:
    x = np.linspace(0.0, 1900.0, 8)
    assert "8 points do not give their error" in _of_points(x, height(x)).notes[0]


def test_stretches_equal_the_slow_twin() -> None:
    rng = np.random.default_rng(5)
    x = np.cumsum(rng.random(200))
    holds = rng.random(200) < 0.6
    slow, start = [], None
    for i in range(200):
        if holds[i] and start is None:
            start = x[i]
        if holds[i] and (i == 199 or not holds[i + 1]):
            slow.append(Stretch(start, x[i]))
            start = None
    assert stretches(x, holds) == tuple(slow)


def test_the_picture_has_all_that_is_known(database: str, tmp_path: FilePath) -> None:
    events = (
        Event("a", "B", runout_x_m=1500.0, release_elevation_m=900.0),
        Event("b", "B", runout_elevation_m=400.0),
        Event("c", "B", left_profile=True),
    )
    with writing(database) as session:
        save_records(session, bowl(1900.0, events))
    view_path(database, "B", tmp_path / "path.svg")
    drawn = (tmp_path / "path.svg").read_text(encoding="utf-8")
    assert "<svg" in drawn
    assert drawn.count("<use") > 96


def _site(length_m: float = 1900.0):
    records = bowl(length_m)
    return path_site(records.paths[0], records.profiles[0])


def run_alone(site: Site, mu: float) -> Runout:
    return run_site(site, mu, no_resistance(site.terrain))


@pytest.mark.parametrize("mu", [0.42, 0.5, 0.6])
def test_the_stop_is_that_of_small_steps(mu: float) -> None:
    found = run_alone(_site(), mu)
    assert found.status == "stopped"
    assert found.runout_x_m == pytest.approx(stop_x(mu), abs=0.05)


def test_speeds_run_from_release_to_stop() -> None:
    found = run_alone(_site(), 0.45)
    x = np.array([place.x_m for place in found.speeds])
    speed = np.array([place.speed_m_s for place in found.speeds])
    assert (x[0], speed[0], speed[-1]) == (0.0, 0.0, 0.0)
    assert x[-1] == found.runout_x_m
    assert np.diff(x).max() == pytest.approx(np.diff(x).min())
    assert len(x) == 100
    assert np.all(speed[1:-1] > 0.0)
    assert found.speed_max_m_s >= speed.max()


def test_short_runs_have_a_place_every_ten_metres() -> None:
    found = run_alone(_site(), 0.75)
    x = [place.x_m for place in found.speeds]
    assert 5.0 < x[1] - x[0] <= 10.0


def test_a_run_that_leaves_or_does_not_start() -> None:
    left = run_alone(_site(1000.0), 0.2)
    assert (left.status, left.runout_x_m, left.runout_elevation_m) == ("left_profile", None, None)
    assert left.speeds[-1].x_m == 1000.0
    assert left.speeds[-1].speed_m_s > 10.0
    held = run_alone(_site(), 0.9)
    assert (held.status, held.runout_x_m) == ("not_released", 0.0)
    assert held.speeds == (SpeedHere(0.0, 0.0),)


def test_the_curve_is_that_of_small_steps() -> None:
    found = with_table(run_alone(_site(), 0.45), _site(), no_resistance(_site().terrain))
    assert found.table is not None
    assert found.jumps == ()
    by_mu = {row.mu: row for row in found.table}
    bowl_height = smooth_bowl().height
    for mu in (0.45, 0.6):
        row = by_mu[mu]
        assert row.runout_x_m == pytest.approx(stop_x(mu), abs=0.05)
        beside = [stop_x(mu - 0.0025), stop_x(mu + 0.0025)]
        assert row.dx_dmu_m == pytest.approx((beside[1] - beside[0]) / 0.005, rel=0.01)
        fall = bowl_height(beside[1]) - bowl_height(beside[0])
        assert row.dy_dmu_m == pytest.approx(fall / 0.005, rel=0.01)
    held = by_mu[0.9]
    assert (held.status, held.runout_x_m, held.dx_dmu_m) == ("not_released", 0.0, None)


def test_a_terrace_is_a_jump_of_the_curve() -> None:
    x = np.linspace(0.0, 1600.0, 161)
    slope = np.select([x < 500.0, x < 650.0, x < 1000.0], [0.7, 0.0, 0.7], 0.1)
    y = 1200.0 - np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(x))])
    site = path_site(Path("T"), Profile("T", x, y))
    found = with_table(run_alone(site, 0.5), site, no_resistance(site.terrain))
    assert found.table is not None
    assert found.jumps
    widest = max(found.jumps, key=lambda jump: jump.from_x_m - jump.to_x_m)
    assert widest.from_x_m - widest.to_x_m > 150.0
    # No run between its frictions stops within, however fine.
    for mu in np.linspace(widest.mu_low, widest.mu_high, 21):
        place = run_alone(site, float(mu)).runout_x_m
        assert place is not None
        assert not widest.to_x_m + 20.0 < place < widest.from_x_m - 20.0
    mu, values = with_gaps(found.table, "runout_x_m", {jump.mu_low for jump in found.jumps})
    at = np.flatnonzero(mu == widest.mu_low)
    assert np.isfinite(values[at[0]])
    assert np.isnan(values[at[1]])


def test_from_the_database(database: str) -> None:
    with writing(database) as session:
        save_records(session, bowl())
    found = run_block(database, "B", RunoutRequest(mu=0.45))
    assert found == run_alone(_site(), 0.45)
    assert (found.path_id, found.lift_off_x_m) == ("B", None)
    with pytest.raises(AvahazardError, match="friction is 0"):
        run_block(database, "B", RunoutRequest(mu=0.0))


@pytest.mark.parametrize(("name", "law"), [("plain", "exponential"), ("gibbs", "exponential")])
def test_friction_is_the_median_over_the_posterior(twin_models: str, name: str, law: str) -> None:
    found = run_block(twin_models, "scey", RunoutRequest(model=name, volume_m3=2e4))
    model = load_stored(twin_models, name)[0]
    u = model.draws[:, :2]
    expected = np.median(np.exp(LAWS[law].log_friction(u, np.array([2e4]))))
    assert found.mu == pytest.approx(expected, rel=1e-12)
    assert found.mu_from == "posterior median"
    plain = run_block(twin_models, "scey", RunoutRequest(mu=found.mu))
    assert found.runout_x_m == plain.runout_x_m
    assert found.speeds == plain.speeds
    assert (found.model, found.volume_m3) == (name, 2e4)
    assert found.notes == (f"the chains of {name} have not converged.",)


def test_normal_friction_without_centrifugal(twin_models: str) -> None:
    found = run_block(twin_models, "scey", RunoutRequest(model="normal", volume_m3=2e4))
    model = load_stored(twin_models, "normal")[0]
    natural = LAWS["power"].to_natural(model.draws[:, :2])
    assert found.mu == pytest.approx(np.median(natural[:, 0] * 2e4 ** -natural[:, 1]))
    # Without the load of curvature the block runs further at the same friction.
    curved = run_block(twin_models, "scey", RunoutRequest(mu=found.mu))
    assert found.runout_x_m > curved.runout_x_m + 20.0


def test_a_path_has_its_own_friction(twin_models: str) -> None:
    model = load_stored(twin_models, "paths")[0]
    base = np.exp(model.draws[:, 0] - model.draws[:, 1] * 0.02)
    for path_id in ("scey", "saugy"):
        found = run_block(twin_models, path_id, RunoutRequest(model="paths", volume_m3=2e4))
        expected = np.median(base * np.exp(model.offsets[path_id]))
        assert found.mu == pytest.approx(expected)


def test_an_effect_on_the_motion_acts(twin_models: str) -> None:
    found = run_block(twin_models, "scey", RunoutRequest(model="drag", mu=0.45))
    plain = run_block(twin_models, "scey", RunoutRequest(mu=0.45))
    assert found.mu_from == "given"
    assert found.speed_max_m_s < plain.speed_max_m_s
    assert found.runout_x_m < plain.runout_x_m


def test_the_curve_is_that_of_the_models_motion(twin_models: str) -> None:
    found = run_block(twin_models, "scey", RunoutRequest(model="drag", mu=0.45, table=True))
    assert found.table is not None
    row = next(row for row in found.table if row.mu == 0.45)
    assert row.runout_x_m == pytest.approx(found.runout_x_m, abs=3.0)
    plain = run_block(twin_models, "scey", RunoutRequest(mu=0.45))
    assert plain.table is None
    assert row.runout_x_m < plain.runout_x_m - 5.0


def test_a_path_that_the_model_does_not_know(twin_models: str) -> None:
    found = run_block(twin_models, "gurraz", RunoutRequest(model="plain", volume_m3=2e4))
    assert (
        found.mu == run_block(twin_models, "scey", RunoutRequest(model="plain", volume_m3=2e4)).mu
    )


@pytest.mark.parametrize("volume", [None, 0.0, -5.0, float("nan")])
def test_neither_friction_nor_volume(twin_models: str, volume: float | None) -> None:
    with pytest.raises(AvahazardError, match=r"volume is|no friction"):
        run_block(twin_models, "scey", RunoutRequest(model="plain", volume_m3=volume))


def test_records_that_changed_are_noted(twin_models: str, tmp_path: FilePath) -> None:
    database = str(shutil.copy(twin_models, tmp_path / "mine.db"))
    with writing(database) as session:
        new = Event("new", "scey", runout_elevation_m=1100.0, volume_m3=1e4)
        save_records(session, Records(events=(new,)))
    assert any(
        "have changed" in n
        for n in run_block(database, "scey", RunoutRequest(model="gibbs", volume_m3=1e4)).notes
    )
