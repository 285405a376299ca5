"""Path offsets: the kernel against a plain optimiser, event by event."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from avahazard.inference.likelihood.event_terms import event_terms
from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.path_offsets import newton_offsets

N_EVENTS, N_VOLUMES, N_GROUPS = 30, 3, 4


def setting(seed: int) -> tuple[Nodes, np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    nodes = Nodes(
        place=np.log(0.4) + 0.1 * rng.standard_normal((N_EVENTS, 5)),
        weight=rng.uniform(0.1, 1.0, (N_EVENTS, 5)),
        log_scale=np.zeros(N_EVENTS),
        is_probability=rng.uniform(size=N_EVENTS) < 0.2,
        floor=np.zeros(N_EVENTS),
        seen_place=np.zeros((N_EVENTS, 5)),
        seen_weight=np.zeros((N_EVENTS, 5)),
        seen_floor=np.zeros(N_EVENTS),
        has_limit=np.zeros(N_EVENTS, dtype=np.bool_),
        log_wrong=np.full(N_EVENTS, -np.inf),
    )
    location = np.log(0.45) + 0.05 * rng.standard_normal((N_EVENTS, N_VOLUMES))
    return nodes, location, np.full_like(location, 0.15), np.full(location.shape, 1 / N_VOLUMES)


@pytest.mark.parametrize("in_log", [True, False])
def test_offsets_are_where_a_plain_optimiser_finds_them(in_log: bool) -> None:
    nodes, location, scatter, weight = setting(1)
    if not in_log:
        nodes = nodes._replace(place=np.exp(nodes.place))
        location = np.exp(location)
    group = np.arange(N_EVENTS) % (N_GROUPS + 1) - 1
    keep = np.arange(N_EVENTS) % 7 != 0
    precision = 0.1**-2.0
    found, bend, value = newton_offsets(
        nodes, location, scatter, weight, False, in_log, group, keep, N_GROUPS, precision
    )
    for k in range(N_GROUPS):
        mine = (group == k) & keep

        def cost(offset: float, mine: np.ndarray = mine) -> float:
            moved = location + offset if in_log else location * np.exp(offset)
            total = event_terms(nodes, moved, scatter, weight).value[mine].sum()
            return float(0.5 * precision * offset**2 - total)

        best = minimize_scalar(cost, bounds=(-1.0, 1.0), method="bounded", options={"xatol": 1e-9})
        # On log μ the steps leave out the bend of the exponential, and end a little short.
        assert found[k] == pytest.approx(best.x, abs=2e-6 if in_log else 1e-3)
        h = 1e-3
        curvature = (cost(best.x + h) - 2.0 * cost(best.x) + cost(best.x - h)) / h**2
        assert bend[k] == pytest.approx(curvature, rel=1e-2 if in_log else 0.3)
        there = location + best.x if in_log else location * np.exp(best.x)
        given = event_terms(nodes, there, scatter, weight).value
        np.testing.assert_allclose(value[mine], given[mine], atol=1e-4 if in_log else 5e-3)
    assert np.all(value[~keep] == 0.0)
