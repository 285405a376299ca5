"""Avalanches whose friction goes up and down along the track, made step by step."""

from __future__ import annotations

import numpy as np

from avahazard.records.collection import Event, Path, Profile, Records, Speed

GRAVITY = 9.81
STEP_M = 1.0
LENGTH_M = 1900.0


def ground(k: int, x: np.ndarray) -> np.ndarray:
    """Height of path k: a bowl, a little steeper on each path."""
    return np.asarray(1000.0 - (0.80 + 0.03 * k) * x + 2.1e-4 * x**2)


def run(k: int, friction: np.ndarray, drag: float) -> np.ndarray:
    """Squares of speed at every metre of path k, to the stop (0 from there on).

    dw/dx = 2 (-g y' - μ (g + y'' w / (1 + y'²)) - drag w sqrt(1 + y'²)), by Heun's steps.
    """
    x = np.arange(0.0, LENGTH_M, STEP_M)
    slope, bend = -(0.80 + 0.03 * k) + 4.2e-4 * x, 4.2e-4

    def rate(j: int, w: float) -> float:
        load = GRAVITY + bend * w / (1.0 + slope[j] ** 2)
        dragging = drag * w * np.sqrt(1.0 + slope[j] ** 2)
        return float(2.0 * (-GRAVITY * slope[j] - friction[j] * load - dragging))

    square = np.zeros(len(x))
    for j in range(len(x) - 1):
        first = rate(j, square[j])
        second = rate(j + 1, max(square[j] + STEP_M * first, 0.0))
        square[j + 1] = square[j] + 0.5 * STEP_M * (first + second)
        if square[j + 1] <= 0.0:
            square[j + 1] = 0.0
            return square
    return square


def made(
    seed: int,
    uneven: float,
    *,
    n_events: int = 24,
    n_paths: int = 4,
    drag: float = 0.0,
    level: float = 0.45,
    correlation_m: float = 100.0,
    n_speeds: int = 9,
    share: float = 1.0,
) -> Records:
    """Events of friction log N(log level, 0.12), with deviations of sd `uneven` along the track.

    A `share` of them has speeds, with errors of 1 m/s at places between release and stop. One that
    does not come 300 m far is not recorded.
    """
    rng = np.random.default_rng(seed)
    x = np.arange(0.0, LENGTH_M, STEP_M)
    fade = np.exp(-STEP_M / correlation_m)
    events, speeds = [], []
    while len(events) < n_events:
        i, k = len(events), len(events) % n_paths
        noise = rng.standard_normal(len(x)) * np.sqrt(1.0 - fade**2)
        deviation = np.empty(len(x))
        deviation[0] = rng.standard_normal()
        for j in range(1, len(x)):
            deviation[j] = fade * deviation[j - 1] + noise[j]
        friction = level * np.exp(0.12 * rng.standard_normal()) + uneven * deviation
        square = run(k, friction, drag)
        moving = np.flatnonzero(square > 0.0)
        if len(moving) < 300 or moving[-1] > LENGTH_M - 10.0:
            continue
        stop = float(x[moving[-1]])
        read = float(ground(k, np.array(stop))) + 5.0 * rng.standard_normal()
        events.append(Event(f"e{i}", path_id=f"P{k}", runout_elevation_m=read, runout_sigma_m=5.0))
        if i < share * n_events:
            for place in stop * (np.arange(n_speeds) + 1.0) / (n_speeds + 1.0):
                true = np.sqrt(np.interp(place, x, square))
                told = max(float(true + rng.standard_normal()), 0.0)
                speeds.append(Speed(f"e{i}", told, 1.0, x_m=float(round(place))))
    line = np.arange(0.0, LENGTH_M + 1.0, 20.0)
    names = [f"P{k}" for k in range(n_paths)]
    return Records(
        paths=tuple(Path(name) for name in names),
        profiles=tuple(Profile(n, line, ground(k, line)) for k, n in enumerate(names)),
        events=tuple(events),
        speeds=tuple(speeds),
    )
