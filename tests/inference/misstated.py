"""Lengths without a profile whose errors are other than they state."""

from __future__ import annotations

from functools import cache

import numpy as np

from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.collection import Event, Records


@cache
def misstated(record: float, volume: float, seed: int, n: int = 800) -> Observations:
    """Lengths whose errors, stated as 20 m and 0.3, are `record` and `volume` times as large."""
    rng = np.random.default_rng(seed)
    height = np.exp(rng.uniform(np.log(150.0), np.log(2000.0), n))
    log_volume = np.log(1e5) + 0.9 * rng.standard_normal(n)
    log_mu = np.log(0.5) - 1e-6 * np.exp(log_volume) + 0.1 * rng.standard_normal(n)
    length = height / np.exp(log_mu) + 20.0 * record * rng.standard_normal(n)
    told = log_volume + 0.3 * volume * rng.standard_normal(n)
    events = tuple(
        Event(
            f"e{i}",
            fall_height_m=float(height[i]),
            runout_length_m=float(length[i]),
            runout_sigma_m=20.0,
            volume_m3=float(np.exp(told[i])),
            volume_rel_sigma=0.3,
        )
        for i in range(n)
    )
    return build_observations(Records(events=events))
