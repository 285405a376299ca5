"""The posterior mode and the curvature there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from avahazard.inference.likelihood.nodes import Nodes
from avahazard.inference.likelihood.posterior import Posterior

Floats = NDArray[np.float64]

STEP = 1e-3
"""Step of the finite differences, in coordinates of order one."""
FIRST_SPREAD = 0.5
"""Coordinate from which spreads between groups are sought."""


@dataclass(frozen=True, slots=True, eq=False)
class Mode:
    """A mode and the normal with its curvature.

    Coordinates `[n_slots]`, the log density there, and the covariance `[n_slots, n_slots]`.
    """

    u: Floats
    log_density: float
    covariance: Floats


def start_coordinates(posterior: Posterior) -> Floats:
    """Coordinates near the data: least squares of the law on each event's likely friction."""
    layout = posterior.layout
    u = np.array([s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots])
    u[list(layout.spreads.values())] = FIRST_SPREAD
    index = tuple(
        int(np.argmin(np.abs(np.asarray(layout.slots[a].grid) - u[a])))
        for a in (
            *layout.tables,
            *(() if layout.speed_scatter is None else (layout.speed_scatter,)),
        )
    )
    friction = likely_friction(posterior.nodes.point(index), layout.log_scatter)
    middle = posterior.observations.volumes.log_volume.shape[1] // 2
    volume = np.exp(posterior.observations.volumes.log_volume[:, middle])
    n = len(layout.law.coordinates)
    # Two starts, and the likelier: least squares can be led astray by one wild record.
    rough = u.copy()
    rough[:n] = layout.law.start(volume, friction)
    tried = [rough, u]
    best = max(tried, key=posterior.log_density)
    return np.asarray(np.clip(best, layout.low, layout.high))


def likely_friction(nodes: Nodes, in_log: bool) -> Floats:
    """Mean friction of each event's nodes `[n_events]`, nan for events that left the profile."""
    mean = np.sum(nodes.place * nodes.weight, axis=1)
    friction = np.exp(mean) if in_log else mean
    return np.where(nodes.is_probability, np.nan, friction)


def find_mode(
    posterior: Posterior, start: Floats | None = None, covariance: Floats | None = None
) -> Mode:
    """Maximise the posterior density within its bounds (L-BFGS-B), from `start` or the data.

    `covariance` may be given where a near fit knows it well enough; else it is found.
    """
    layout = posterior.layout
    u = start_coordinates(posterior) if start is None else np.clip(start, layout.low, layout.high)
    bounds = list(zip(layout.low, layout.high, strict=True))

    def cost(v: Floats) -> float:
        value = posterior.log_density(np.clip(v, layout.low, layout.high))
        return -value if np.isfinite(value) else 1e10

    for _ in range(2):
        found = minimize(
            cost, u, method="L-BFGS-B", bounds=bounds, options={"maxiter": 200, "eps": 1e-6}
        )
        u = np.clip(found.x, layout.low, layout.high)
    if covariance is None:
        covariance = _covariance(cost, u, layout.low, layout.high)
    return Mode(u, -float(found.fun), covariance)


def _covariance(cost, u: Floats, low: Floats, high: Floats) -> Floats:  # type: ignore[no-untyped-def]
    """Inverse of the Hessian of the cost, kept positive and finite."""
    n = len(u)
    # At a bound the differences are taken one step inside.
    centre = np.clip(u, low + 2 * STEP, high - 2 * STEP)
    steps = STEP * np.eye(n)
    middle = cost(centre)
    ahead = np.array([cost(centre + step) for step in steps])
    behind = np.array([cost(centre - step) for step in steps])
    hessian = np.diag(ahead + behind - 2.0 * middle)
    for i in range(n):
        for j in range(i + 1, n):
            # Both steps forwards and both back, less the steps by themselves.
            both = cost(centre + steps[i] + steps[j]) + cost(centre - steps[i] - steps[j])
            alone = ahead[i] + behind[i] + ahead[j] + behind[j]
            hessian[i, j] = hessian[j, i] = 0.5 * (both - alone) + middle
    hessian /= STEP * STEP
    values, vectors = np.linalg.eigh(hessian)
    values = np.clip(values, 0.05, 1e8)
    return np.asarray((vectors / values) @ vectors.T)
