"""Quadrature of a discrete measure by two nodes a panel."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.likelihood.panels import A_PANEL, panel_nodes


@pytest.mark.parametrize("panels", [6, 7, 11])
def test_no_mass_is_lost_and_three_moments_are_kept(panels: int) -> None:
    # Among so many some have a last edge that rounding puts before the last point.
    rng = np.random.default_rng(8)
    for _ in range(200):
        points, masses = np.sort(rng.normal(-0.7, 0.4, 25)), rng.random(25)
        place, weight = np.full(A_PANEL * panels, np.nan), np.full(A_PANEL * panels, np.nan)
        panel_nodes(points, masses, panels, place, weight)
        assert weight.sum() == pytest.approx(1.0, rel=1e-12)
        for power in (1, 2, 3):
            expected = np.sum(masses * points**power) / masses.sum()
            assert np.sum(weight * place**power) == pytest.approx(expected, rel=1e-9)
