"""Points and band of the figure of friction against volume belong together."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.workflow.model_friction import apparent_friction, friction_view, from_reference

DRAG = definition("turbulent-drag").build({})
SIGMA, STRENGTH, N = 0.1, 0.004, 180
X = np.arange(0.0, 3601.0, 30.0)
PROFILE = Profile("p", X, 2500.0 - 0.9 * X + 1.2e-4 * X**2)


def world(offset: float = 0.0) -> tuple[FittedModel, np.ndarray]:
    """Events stopped by drag and a friction that is known, and the model that they come from."""
    rng = np.random.default_rng(4)
    volume = np.exp(rng.uniform(np.log(2e3), np.log(2e5), N))
    log_mu = np.log(0.5) - 1e-6 * volume + SIGMA * rng.standard_normal(N)
    events = [
        Event(f"e{k}", path_id="p", volume_m3=v, runout_x_m=1.0) for k, v in enumerate(volume)
    ]
    observations = build_observations(Records((Path("p"),), (PROFILE,), tuple(events[:1])))
    strength = {"turbulent-drag": np.array([STRENGTH])}
    curve = predict_records(observations, (DRAG,), strength).curve
    x, _, status = curve.at(np.exp(log_mu + offset)[None, :])
    assert (status == 0).all()
    records = Records(
        (Path("p"),),
        (PROFILE,),
        tuple(
            Event(e.event_id, path_id="p", volume_m3=e.volume_m3, runout_x_m=float(place))
            for e, place in zip(events, x[0], strict=True)
        ),
    )
    slot = STRENGTH / DRAG.parameters[0].prior_sd
    draws = np.tile([np.log(0.5), 1.0, np.log(SIGMA), slot], (50, 1))
    posterior = Posterior(build_observations(records), Specification(), (DRAG,))
    offsets = {"p": np.full(50, offset)} if offset else {}
    return fitted_model(posterior, draws, offsets), np.exp(log_mu)


def inside(model: FittedModel, mu: np.ndarray) -> float:
    view = friction_view(model)
    assert view is not None
    assert view.scatter is not None
    log_volume = model.observations.columns.log_volume
    low, high = (np.interp(log_volume, np.log(view.volume), view.scatter[k]) for k in (0, 3))
    return float(np.mean((mu >= low) & (mu <= high)))


@pytest.mark.parametrize("offset", [0.0, 0.15])
def test_nine_in_ten_events_lie_in_the_band_of_an_adequate_model(offset: float) -> None:
    model, mu = world(offset)
    found = apparent_friction(model)[0].mu * np.exp(-from_reference(model))
    assert np.nanmax(np.abs(found / mu - 1.0)) < 0.01
    assert found.min() > MU[0]
    assert inside(model, found) == pytest.approx(0.9, abs=0.05)


def test_friction_without_the_drag_that_was_at_work_would_lie_outside() -> None:
    model, _ = world()
    plain = back_calculate(model.observations, predict_records(model.observations, (), {})).mu
    assert inside(model, plain) < 0.3
