"""Grossly wrong records, which heavy tails of friction alone cannot bear.

A wrong record may lie where no friction stops a block, on a steep slope: it then costs as many
nats as its distance in record errors asks for, and any effect that moves it a little gains most of
them. With Student's tails a record is therefore a mixture (Box and Tiao 1968, Biometrika 55, 119):
some lie anywhere on their path, a share of all that is estimated (`layout.WRONG_SHARE`).
"""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, Observations

LONGEST_LENGTH = 10.0
"""Reach of recorded lengths, in fall heights."""


def wrong_ranges(observations: Observations) -> tuple[Floats, Floats]:
    """Lowest and highest record (m) that each event could have had `[n_events]`.

    NaN for those that left, and for those with speeds, whose record the speeds bear out.
    """
    low, high = np.full(observations.n_events, np.nan), np.full(observations.n_events, np.nan)
    has_speed = {m.event for m in observations.speeds}
    for i, kind in enumerate(observations.kind):
        if kind == LEFT or i in has_speed:
            continue
        if kind == LENGTH:
            low[i], high[i] = 0.0, LONGEST_LENGTH * observations.fall_height[i]
            continue
        site = observations.sites[observations.columns.path_index[i]]
        line = site.heights() if kind == ELEVATION else site.terrain_x
        low[i], high[i] = np.min(line), np.max(line)
    return low, high


def log_wrong(observations: Observations) -> Floats:
    """Log density (1/m) of each record, were it wrong `[n_events]`; -inf for those that are not."""
    low, high = wrong_ranges(observations)
    density = -np.log(high - low)
    return np.where(np.isnan(density), -np.inf, density)


def by_wrong_share(log_wrong: Floats, value: Floats, log_share: float) -> Floats:
    """Derivative by the log of the share of wrong records of each event's `value` `[n_events]`.

    `log_wrong` `[n_events]` has that share in it, as `value` has.
    """
    wrong = np.exp(np.minimum(log_wrong - value, 0.0))
    odds = np.exp(log_share) / -np.expm1(log_share)
    return np.where(np.isfinite(log_wrong), wrong - (1.0 - wrong) * odds, 0.0)
