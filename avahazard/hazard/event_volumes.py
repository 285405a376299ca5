"""How often avalanches come down a path and how large they are, with what is not known of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats

ANY_VOLUME_M3 = 1e4
"""Stands for the volume where it does not matter."""
NODE_STEP = 0.15
MAX_NODES = 48
"""Nodes over log volume: about one for each 15 %."""


@dataclass(frozen=True, slots=True, eq=False)
class EventVolumes:
    """Posterior draws of the rate of avalanches and of the distribution of their volumes.

    `rate` `[n_parameters]` a year; `share` `[n_parameters, n_volumes]` of the avalanches have
    the volumes `log_volume` `[n_volumes]` (log m3, rising), and sum to 1. `seen_only`: they are
    those of the records, which lack what nobody saw.
    """

    rate: Floats
    log_volume: Floats
    share: Floats
    seen_only: bool = False


def one_volume(volume_m3: float, n_parameters: int, rate: float = 1.0) -> EventVolumes:
    """Avalanches of one volume at a known rate."""
    return EventVolumes(
        np.full(n_parameters, rate), np.array([np.log(volume_m3)]), np.ones((n_parameters, 1))
    )


def event_volumes(
    rate: Floats, rate_over: Callable[[Floats], Floats], low: float, high: float
) -> EventVolumes:
    """Gather a frequency on nodes between two log volumes.

    `rate_over` maps log volumes `[n]` to the yearly rates of larger avalanches
    `[n_parameters, n]`; what lies past the ends counts at the end nodes.
    """
    n = int(np.clip(np.ceil((high - low) / NODE_STEP) + 1, 1, MAX_NODES))
    nodes = np.linspace(low, high, n)
    over = rate_over(0.5 * (nodes[1:] + nodes[:-1]))
    ends = np.zeros((len(rate), 1))
    over = np.minimum(np.hstack([rate[:, None], over, ends]), rate[:, None])
    with np.errstate(invalid="ignore", divide="ignore"):
        share = -np.diff(np.minimum.accumulate(over, axis=1), axis=1) / rate[:, None]
    # A rate of nought has no volumes: any will do.
    share[rate <= 0.0] = 1.0 / n
    return EventVolumes(rate, nodes, share)


def with_volumes(volumes: EventVolumes, log_volume: Floats) -> EventVolumes:
    """The same with nodes at more log volumes, which have no share."""
    more = np.setdiff1d(log_volume, volumes.log_volume)
    nodes = np.concatenate([volumes.log_volume, more])
    share = np.hstack([volumes.share, np.zeros((len(volumes.rate), len(more)))])
    order = np.argsort(nodes)
    return replace(volumes, log_volume=nodes[order], share=share[:, order])
