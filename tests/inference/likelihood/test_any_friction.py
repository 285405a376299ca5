"""Frictions from a thousandth to nearly three come back, on profiles and without."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Path, Profile, Records

Floats = np.ndarray


def records_on(x: Floats, y: Floats, mu: Floats) -> Records:
    """A record where each friction stops without the centrifugal force: on the energy line."""
    fine = np.linspace(x[0], x[-1], 400_000)[1:]
    fall = (y[0] - np.interp(fine, x, y)) / (fine - x[0])
    place = [fine[np.argmax(fall < m)] for m in mu]
    events = tuple(
        Event(f"e{k}", path_id="P", runout_x_m=float(p), runout_sigma_m=0.5, volume_m3=1e5)
        for k, p in enumerate(place)
    )
    return Records((Path("P"),), (Profile("P", x, y),), events, ())


@pytest.mark.parametrize(
    ("friction", "drop", "length", "flat"),
    [(0.004, 30.0, 2000.0, 0.0005), (0.015, 200.0, 2000.0, 0.002), (2.2, 3000.0, 700.0, 0.1)],
)
def test_friction_comes_back_whatever_it_is(
    friction: float, drop: float, length: float, flat: float
) -> None:
    x = np.linspace(0.0, 20.0 * length, 800)
    y = drop * np.exp(-x / length) + flat * (x[-1] - x)
    mu = friction * np.exp(0.1 * np.linspace(-1.5, 1.5, 9))
    observations = build_observations(records_on(x, y, mu))
    model = assemble(observations, Specification(law="constant", centrifugal=False), {})
    log_a, log_sigma = find_mode(model).u
    assert np.exp(log_a) == pytest.approx(friction, rel=0.02)
    assert np.exp(log_sigma) == pytest.approx(np.std(np.log(mu)), rel=0.2)
