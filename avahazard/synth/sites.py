"""Made-up avalanche paths: steep at the top, stepped, concave, gentle at the bottom."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.records.path import Path, Profile
from avahazard.synth.seeds import generator
from avahazard.synth.settings import SitePlan

SPACING_M = 15.0
FIRST_YEAR, LAST_YEAR = 1900, 2020
RUN_ON_M, RUN_ON_SPACING_M = 5000.0, 50.0
"""How far the last slope of a made-up path goes on, so that rare avalanches stop on the profile."""
BEND_M, VALLEY_SLOPE = 300.0, 0.03
"""Over what distance the run-out of a falling path flattens, and to which slope."""
MOST_RISE = 0.25
"""How far up a rising run-out climbs at most, of the drop: it stays below the release."""


def concave_profile(
    drop_m: float,
    top_m: float,
    slopes: tuple[float, float] = (1.0, 0.10),
    power: float = 1.5,
    waves: tuple[tuple[float, float, float], ...] = (),
    tail: tuple[float, float] = (0.0, 0.0),
    spacing_m: float = SPACING_M,
) -> tuple[Floats, Floats]:
    """Profile points x, y `[n_points]` in metres of a path with a given drop.

    The slope falls from `slopes[0]` to `slopes[1]` as (1 - t)^power of the relative
    distance t. Each wave (amplitude, number over the path, phase) varies it in the middle
    of the path, which makes steps. `tail` (length in m, slope) follows the lowest point;
    a negative slope rises to the other side of the valley.
    """
    t = np.linspace(0.0, 1.0, 4001)
    slope = slopes[1] + (slopes[0] - slopes[1]) * (1.0 - t) ** power
    in_middle = np.clip((t - 0.12) / 0.1, 0.0, 1.0) * np.clip((0.9 - t) / 0.2, 0.0, 1.0)
    steps = sum((a * np.sin(2 * np.pi * (k * t + phase)) for a, k, phase in waves), np.zeros(4001))
    slope = slope * (1.0 + in_middle * steps)
    length = drop_m / float(np.trapezoid(slope, t))
    x = np.arange(0.0, length + tail[0] + spacing_m, spacing_m)
    # The slope bends over 150 m into that of the tail.
    into_tail = (
        np.clip((x - length + 75.0) / 150.0, 0.0, 1.0) if tail[0] > 0.0 else np.zeros(len(x))
    )
    at = np.interp(x / length, t, slope) * (1.0 - into_tail) + tail[1] * into_tail
    fall = np.concatenate([[0.0], np.cumsum(0.5 * (at[1:] + at[:-1]) * spacing_m)])
    return np.round(x, 1), np.round(top_m - fall, 3)


def make_sites(seed: int, n_paths: int, n_events: int) -> tuple[SitePlan, ...]:
    """`n_paths` paths with drops of 600 to 2000 m and about `n_events` / `n_paths` events each."""
    rng = generator(seed, "sites")
    weights = rng.lognormal(0.0, 0.4, n_paths)
    least = min(6, n_events // n_paths)
    counts = least + rng.multinomial(n_events - least * n_paths, weights / weights.sum())
    sections = rng.permutation(["channelled", "open"] * ((n_paths + 1) // 2))[:n_paths]
    return tuple(
        _make_site(rng, f"P{k + 1:02d}", str(sections[k]), int(counts[k])) for k in range(n_paths)
    )


def _make_site(rng: np.random.Generator, path_id: str, section: str, n_events: int) -> SitePlan:
    drop = float(rng.uniform(600.0, 2000.0))
    waves = tuple(
        (float(rng.uniform(0.02, 0.09)), float(rng.uniform(low, low + 1.5)), float(rng.uniform()))
        for low in (1.0, 2.5, 4.0)
    )
    counter_slope = rng.uniform() < 0.2
    x, y = concave_profile(
        drop,
        top_m=float(rng.uniform(2000.0, 2900.0)),
        slopes=(float(rng.uniform(0.95, 1.1)), float(rng.uniform(0.05, 0.12))),
        power=float(rng.uniform(1.3, 1.9)),
        waves=waves,
        tail=(float(rng.uniform(300.0, 500.0)), -0.12 if counter_slope else 0.06),
    )
    length, fall = float(x[-1]), float(y.max() - y.min())
    x, y = _run_on(x, y)
    cover = np.full(len(x), "open", dtype=object)
    if rng.uniform() < 0.65:
        first = rng.uniform(0.35, 0.6)
        t = x / length
        cover[(t > first) & (t < first + rng.uniform(0.1, 0.3))] = "forest"
    return SitePlan(
        path=Path(
            path_id,
            name=f"Synthetic path {path_id}",
            location="made up",
            orientation=str(rng.choice(["N", "NE", "E", "SE", "S", "SW", "W", "NW"])),
            section=section,
            catchment_ha=round(float(rng.lognormal(2.5, 0.6)), 1),
            observed_from=FIRST_YEAR,
            observed_to=LAST_YEAR,
        ),
        profile=Profile(path_id, x, y, land_cover=tuple(str(c) for c in cover)),
        n_events=n_events,
        volume_median_m3=float(rng.lognormal(np.log(7e4), 0.5)),
        drop_m=fall,
    )


def _run_on(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The profile, and `RUN_ON_M` more of it; what was there stays as it was.

    Where it falls it flattens to the valley's floor; where it rises it goes on to rise, ever less,
    by `MOST_RISE` of the path's drop at most.
    """
    step = RUN_ON_SPACING_M
    more = np.arange(step, RUN_ON_M + step, step)
    last = float((y[-2] - y[-1]) / (x[-1] - x[-2]))
    if last >= 0.0:
        floor = min(last, VALLEY_SLOPE)
        slope = floor + (last - floor) * np.clip(1.0 - more / BEND_M, 0.0, 1.0)
    else:
        slope = last * np.exp(-more * (-last) / (MOST_RISE * float(y[0] - y[-1])))
    fall = np.cumsum(slope * step)
    return np.append(x, np.round(x[-1] + more, 1)), np.append(y, np.round(y[-1] - fall, 3))
