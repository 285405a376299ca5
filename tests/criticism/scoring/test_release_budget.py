"""The release's part of the error, in a dataset where every source is known."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.criticism.scoring.error_budget import (
    budget_by_event,
    budget_parts,
    error_budget,
    unexplained,
)
from avahazard.inference.fitted_model import fitted_model
from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Event, Path, Records
from avahazard.synth.dataset import run_track
from tests.criticism.scoring.test_error_budget import rms
from tests.inference.model.test_release_errors import GROUND, TRACK, Z0
from tests.inference.studies import near, posterior

N, SIGMA_Z, SIGMA_M, SCATTER, VOLUME_SD = 700, 20.0, 8.0, 0.05, 0.3
A, SLOPE = 0.52, 0.8


def test_every_part_is_what_it_is_in_the_world_and_they_add_up() -> None:
    rng = np.random.default_rng(8)
    log_volume = rng.normal(np.log(5e4), 0.6, N)
    told = np.exp(log_volume + VOLUME_SD * rng.standard_normal(N))
    law = A * np.exp(-SLOPE * np.exp(log_volume) * 1e-6)
    mu = law * np.exp(SCATTER * rng.standard_normal(N))

    def stops(z0: np.ndarray, friction: np.ndarray) -> np.ndarray:
        status, x, _ = run_track(TRACK, TRACK.place(z0), friction)
        assert (status == 0).all()
        return np.asarray(x)

    right = np.full(N, Z0)
    z0 = Z0 + SIGMA_Z * rng.standard_normal(N)
    recorded = stops(z0, mu) + SIGMA_M * rng.standard_normal(N)
    events = tuple(
        Event(
            f"e{i}",
            "P0",
            runout_x_m=float(recorded[i]),
            runout_sigma_m=SIGMA_M,
            release_elevation_m=Z0,
            volume_m3=float(told[i]),
            volume_rel_sigma=VOLUME_SD,
            covariates={"release_sigma_m": SIGMA_Z},
        )
        for i in range(N)
    )
    records = Records((Path("P0"),), (GROUND,), events)
    model = posterior(build_observations(records))
    u = near(model, **{"log a": np.log(A), "n in 1e-6/m3": SLOPE, "log sigma": np.log(SCATTER)})
    fitted = fitted_model(model, u[None], {})
    budget = error_budget(fitted, np.random.default_rng(2))
    exact = stops(right, law)
    middle = A * np.exp(-SLOPE * np.exp(model.observations.volumes.mean) * 1e-6)
    truth = {
        "record": SIGMA_M**2 + np.zeros(N),
        "release": (stops(z0, mu) - stops(right, mu)) ** 2,
        "scatter": (stops(right, mu) - exact) ** 2,
        "volume": (exact - stops(right, middle)) ** 2,
    }
    for part, squares in truth.items():
        assert rms(getattr(budget, part)) == pytest.approx(rms(squares), rel=0.1), part
    assert rms(truth["release"]) > 2.0 * SIGMA_M
    error = stops(right, middle) - recorded
    assert rms(budget.expected) == pytest.approx(rms(error**2), rel=0.1)
    assert rms(budget.floor**2) == pytest.approx(
        rms(truth["record"] + truth["volume"] + truth["release"]), rel=0.1
    )
    assert unexplained(error, budget) == 0.0
    rows = {row.source: row.rms_m for row in budget_parts(error, budget)}
    assert list(rows) == ["record", "volume", "release", "scatter", "parameters", "unexplained"]
    by_event = budget_by_event(model.observations, error, budget, np.zeros(N))
    assert by_event[3].release_m == pytest.approx(np.sqrt(budget.release[3]))
    without = budget._replace(release=np.zeros(N))
    assert "release" not in [row.source for row in budget_parts(error, without)]
