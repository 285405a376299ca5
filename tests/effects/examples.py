"""Columns and a site of known shape, to compute effects by hand on."""

from __future__ import annotations

import numpy as np

from avahazard.effects.columns import EventColumns, build_columns
from avahazard.effects.site import Site, build_site
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Path, Profile

N_PATHS, N_EVENTS = 6, 36
COVER = ("open",) * 40 + ("forest",) * 30 + ("open",) * 26
SNOW = ("dry", "wet", "dry", "mixed", "dry", "wet")


def paths() -> dict[str, Path]:
    """Six paths, by turns channelled and open; the first is seen below 400 m only."""
    return {
        f"P{k}": Path(
            f"P{k}",
            section=("channelled", "open")[k % 2],
            observed_below_m=400.0 if k == 0 else None,
            covariates={"aspect": 30.0 * k},
        )
        for k in range(N_PATHS)
    }


def events() -> tuple[Event, ...]:
    """36 events, six on each path, dated over 90 years, with every column filled."""
    return tuple(
        Event(
            f"e{i:02d}",
            f"P{i % N_PATHS}",
            date=f"{1900 + 10 * (i // 4)}-0{1 + i // 2 % 4}-1{i % 7}",
            runout_elevation_m=250.0 + 4.0 * i,
            volume_m3=1e4 * (1 + i % 9),
            deposit_length_m=40.0 + i,
            covariates={"snow_type": SNOW[(i // N_PATHS) % 6], "wind": float(i % 5) + 0.1 * i},
        )
        for i in range(N_EVENTS)
    )


def columns(chosen: tuple[Event, ...] | None = None) -> EventColumns:
    """Columns of the events, released from 700 to 945 m."""
    chosen = events() if chosen is None else chosen
    return build_columns(chosen, paths(), 700.0 + 7.0 * np.arange(len(chosen)))


def bowl() -> tuple[np.ndarray, np.ndarray]:
    """Points of y = 1000 - 0.8 x + 2e-4 x²."""
    x = np.linspace(0.0, 1900.0, 96)
    return x, 1000.0 - 0.8 * x + 2e-4 * x**2


def sites(land_cover: tuple[str, ...] | None = COVER) -> tuple[Site, ...]:
    """The same bowl for every path, with forest from x = 800 to 1400 m."""
    x, y = bowl()
    smooth = smooth_profile(x, y)
    return tuple(
        build_site(path, Profile(path.path_id, x, y, land_cover), smooth, [0.0, 200.0])
        for path in paths().values()
    )
