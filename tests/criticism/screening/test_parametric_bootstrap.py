from __future__ import annotations

import numpy as np
import pytest

from avahazard.criticism.screening.parametric_bootstrap import (
    BootstrapRecords,
    actual_records,
    at_friction,
    simulate,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import LEFT, PLACE
from avahazard.inference.seeds import generator
from avahazard.physics.runout_curve import MU
from tests.inference import studies
from tests.inference.groupings import plan_of

N_WORLDS = 300


def many(
    model: Posterior, tau: float = 0.0, track_scatter: float = 0.0, **values: float
) -> list[BootstrapRecords]:
    u = studies.near(model, **values)
    predicted = model.nodes.predicted_at(u)
    plan = plan_of(model.observations, "path-effect")
    return [
        simulate(model, predicted, u, plan, np.array([tau]), track_scatter, generator(1, b))
        for b in range(N_WORLDS)
    ]


@pytest.mark.parametrize("friction", [0.0, MU[0], 0.2345, MU[300], 0.5 * sum(MU[-2:]), MU[-1], 9.0])
def test_squares_at_a_friction_are_those_of_numpy(friction: float) -> None:
    square = np.random.default_rng(3).normal(100.0, 50.0, (len(MU), 4))
    expected = [np.interp(friction, MU, column) for column in square.T]
    np.testing.assert_array_equal(at_friction(square, friction), expected)


def test_the_real_world_is_the_records() -> None:
    observations = studies.observations()
    found = actual_records(studies.posterior(observations))
    stopped = observations.kind != LEFT
    assert np.array_equal(found.left, ~stopped)
    assert np.array_equal(found.observed[stopped], observations.observed[stopped])
    for r, measured in enumerate(observations.speeds):
        k = len(measured.x)
        assert found.tracks.places[r] == k
        assert np.array_equal(found.tracks.speed[r, :k], measured.speed)
        assert np.array_equal(found.tracks.spread[r, :k, :k], measured.spread)


def test_lengths_scatter_by_friction_volume_and_record() -> None:
    observations = studies.observations()
    worlds = many(studies.posterior(observations), **{"log sigma": np.log(0.12)})
    for i in range(36, 39):
        logs = np.log([w.observed[i] for w in worlds])
        # Of log L: scatter, the slope n of the law times the volume's error, record.
        volume = np.exp(observations.volumes.mean[i])
        law = 1e-6 * volume * observations.volumes.sd[i]
        record = observations.sigma[i] / np.exp(np.mean(logs))
        expected = np.sqrt(0.12**2 + law**2 + record**2)
        assert np.std(logs) == pytest.approx(expected, rel=0.15)


def test_paths_are_offset_together() -> None:
    observations = studies.observations()
    model = studies.posterior(observations)
    mine = np.flatnonzero((observations.columns.path_index == 0) & (observations.kind == 0))[:2]

    def correlation(tau: float) -> float:
        pairs = np.array([w.observed[mine] for w in many(model, tau)])
        return float(np.corrcoef(pairs.T)[0, 1])

    assert abs(correlation(0.0)) < 0.2
    assert correlation(0.3) > 0.6


def test_stops_above_the_limit_of_sight_are_not_made() -> None:
    observations = studies.observations()
    limited = np.flatnonzero(np.isfinite(observations.limit) & (observations.kind == 0))
    free = np.flatnonzero(np.isnan(observations.limit) & (observations.kind == 0))
    worlds = many(studies.posterior(observations), **{"log sigma": np.log(0.4)})
    above = np.concatenate(
        [
            (w.observed[seen] - observations.limit[seen]) / observations.sigma[seen]
            for w in worlds
            for seen in [limited[~w.left[limited]]]
        ]
    )
    # Stops lie below the limit; records by their errors alone above it.
    assert 0.0 < np.max(above) < 5.0
    assert any(np.any(w.observed[free] > 520.0) for w in worlds)


def test_speeds_err_as_said() -> None:
    observations = studies.observations()
    model = studies.posterior(observations)
    fixed = {"log sigma": np.log(1e-3), "n in 1e-6/m3": 0.0}
    measured = observations.speeds[0]
    for scatter in (0.0, 0.1):
        tracks = [w.tracks for w in many(model, 0.0, scatter, **fixed)]
        assert all(t.places[0] > 0 for t in tracks)
        speeds = np.array([t.speed[0, 0] for t in tracks])
        own = scatter * np.sqrt(tracks[0].spread[0, 0, 0]) / (2.0 * np.mean(speeds))
        assert np.std(speeds) == pytest.approx(np.hypot(measured.sigma[0], own), rel=0.15)


def test_speeds_are_measured_where_the_avalanche_came() -> None:
    observations = studies.observations()
    measured = observations.speeds[0]
    model = studies.posterior(observations)
    worlds = many(model, **{"log sigma": np.log(0.3)})
    places = np.array([w.tracks.places[0] for w in worlds])
    assert 0 < np.sum(places < len(measured.x)) < N_WORLDS
    i = measured.event
    assert observations.kind[i] == PLACE
    for w, k in zip(worlds, places, strict=True):
        came = (w.observed[i] > measured.x) | w.left[i]
        clear = w.left[i] | (np.abs(measured.x - w.observed[i]) > 5.0 * observations.sigma[i])
        np.testing.assert_array_equal((np.arange(len(came)) < k)[clear], came[clear])


def test_equal_seeds_make_equal_worlds() -> None:
    model = studies.posterior(studies.observations())
    u = studies.near(model)
    predicted = model.nodes.predicted_at(u)
    plan = plan_of(model.observations, "path-effect")

    def one(seed: int) -> BootstrapRecords:
        return simulate(model, predicted, u, plan, np.array([0.1]), 0.05, generator(seed, "a"))

    a, b, c = one(1), one(1), one(2)
    assert np.array_equal(a.observed, b.observed)
    assert np.array_equal(a.tracks.speed, b.tracks.speed)
    assert not np.array_equal(a.observed, c.observed)


def test_worlds_have_students_tails_where_the_model_has() -> None:
    observations = studies.observations()
    i = 36
    kurtosis = {}
    for tails in ("normal", "student"):
        logs = np.log([w.observed[i] for w in many(studies.posterior(observations, tails=tails))])
        z = (logs - np.median(logs)) / np.std(logs)
        kurtosis[tails] = float(np.mean(z**4))
    assert kurtosis["normal"] < 4.0 < kurtosis["student"]
