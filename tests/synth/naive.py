"""Slow, obvious twins of the fast code."""

from __future__ import annotations

from bisect import bisect_right
from math import atan, cos, sin

from scipy.integrate import solve_ivp

from avahazard.synth.dataset import Track

GRAVITY = 9.81


def run_in_time(track: Track, release_x_m: float, mu: float) -> tuple[float, float]:
    """x of the stop and the largest speed, by DOP853 on equation 2.3 in time."""

    knots, coefficients = track.knots_m.tolist(), track.coef.T.tolist()

    def rates(_: float, state: list[float]) -> list[float]:
        x, u = float(state[0]), float(state[1])
        cell = min(max(bisect_right(knots, x) - 1, 0), len(track.forest) - 1)
        d, c = x - knots[cell], coefficients[cell]
        tangent = c[1] + 2 * c[2] * d + 3 * c[3] * d**2
        angle = -atan(tangent)
        curvature = (2 * c[2] + 6 * c[3] * d) / (1 + tangent**2) ** 1.5
        normal = max(0.0, GRAVITY * cos(angle) + track.centrifugal * curvature * u**2)
        weakening = track.weakening_r + (1 - track.weakening_r) / (1 + abs(u) / track.weakening_u0)
        force = GRAVITY * sin(angle) - mu * weakening * normal
        force -= track.constant[cell] + track.quadratic[cell] * u**2
        return [u * cos(angle), force]

    def stopped(_: float, state: list[float]) -> float:
        return state[1]

    stopped.terminal, stopped.direction = True, -1  # type: ignore[attr-defined]
    run = solve_ivp(
        rates, (0, 1000), [release_x_m, 0.0], "DOP853", events=stopped, rtol=1e-8, atol=1e-7,
        max_step=0.25,
    )  # fmt: skip
    assert run.status == 1
    return float(run.y[0, -1]), float(run.y[1].max())
