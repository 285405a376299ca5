"""The band of Holy's density under moved records."""

from __future__ import annotations

import numpy as np

from avahazard.inference.paper.density import holy_density
from avahazard.inference.paper.density_band import density_band

X = np.linspace(0.2, 0.8, 61)


def test_the_band_opens_with_the_records_errors_and_holds_the_density() -> None:
    rng = np.random.default_rng(1)
    mu = rng.normal(0.5, 0.08, 60)
    widths = []
    for sd in (0.0, 0.01, 0.05):
        low, high = density_band(mu + sd * rng.standard_normal((40, 60)), X, 20.0)
        widths.append(float(np.mean(high - low)))
        if sd == 0.01:
            inside = (low <= holy_density(mu, 20.0).pdf(X)) & (
                holy_density(mu, 20.0).pdf(X) <= high
            )
            assert inside.mean() > 0.7
    assert widths[0] == 0.0
    assert widths[0] < widths[1] < widths[2]


def test_replicates_without_a_friction_are_left_out() -> None:
    moved = np.full((5, 3), np.nan)
    assert np.isnan(density_band(moved, X, 5.0)).all()
    moved[2] = [0.4, 0.5, np.nan]
    low, high = density_band(moved, X, 5.0)
    assert np.array_equal(low, high)
    assert np.all(low > 0.0)
