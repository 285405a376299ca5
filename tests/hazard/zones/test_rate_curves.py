"""Rates of avalanches by friction, read from curves, against the sums themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.hazard.avalanches import Avalanches, EventVolumes
from avahazard.hazard.zones.exceeded_speeds import RateCurves, rate_curves
from avahazard.inference.model.specification import Specification
from avahazard.physics.runout_curve import MU
from tests.hazard.naive import rate_below
from tests.hazard.zones.parabola import RATES, SHARES, VOLUMES, avalanches_of, one

RELEASES = (2450.0, 2300.0)


def read(curves: RateCurves, mu: float) -> np.ndarray:
    """Rate of each draw, over its classes."""
    total = np.zeros(len(curves.low))
    for p in range(len(total)):
        for c in range(curves.low.shape[1]):
            nodes = curves.low[p, c] + curves.step[p, c] * np.arange(curves.log_rate.shape[2])
            total[p] += np.exp(np.interp(np.log(mu), nodes, curves.log_rate[p, c]))
    return total


@pytest.mark.parametrize(
    "specification",
    [Specification(), Specification(tails="student"), Specification(distribution="normal")],
)
def test_rates_between_the_nodes(specification: Specification) -> None:
    volumes = EventVolumes(RATES, VOLUMES, SHARES)
    mixed: Avalanches = avalanches_of(one(0.15, 2), volumes, RELEASES, specification)
    curves = rate_curves(mixed)
    for mu in (0.1, 0.25, 0.4, 0.55, 0.7, 0.9, 1.4):
        expected = rate_below(mixed, np.full((2, 2), mu))
        assert read(curves, mu) == pytest.approx(expected, rel=0.01, abs=1e-6)


def test_classes_of_one_friction_are_found_once_and_are_the_same() -> None:
    mixed = avalanches_of(one(0.15, 2), EventVolumes(RATES, VOLUMES, SHARES), RELEASES)
    once = rate_curves(mixed)
    # An ulp apart, and each class goes its own way.
    location = mixed.location.copy()
    location[:, 1] *= 1.0 + 1e-15
    each = rate_curves(replace(mixed, location=location))
    assert once.log_rate == pytest.approx(each.log_rate, rel=1e-9)
    assert once.low == pytest.approx(each.low, rel=1e-9)


def test_friction_that_is_normal_and_may_be_nought_begins_with_the_table() -> None:
    volumes = EventVolumes(RATES, VOLUMES, SHARES)
    wide = avalanches_of(one(0.15, 2), volumes, RELEASES, Specification(distribution="normal"))
    assert np.all(wide.location - 6.0 * wide.scatter < 0.0)
    assert rate_curves(wide).low == pytest.approx(np.log(MU[0]), abs=1e-12)
