"""Avalanches that came down and were not seen: the rate of the records lacks them.

Where stops above a limit are not seen, the records hold a share P(seen | V) of the avalanches of
volume V. So λ(V) = λ_seen(V) / P(seen | V) came, by the friction of the model.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.site import release_place
from avahazard.hazard.avalanches import Avalanches, friction_below
from avahazard.hazard.passing import passing_in_metres, stops
from avahazard.physics.runout_curve import inverse

LEAST_SEEN = 0.05
"""Volumes that are seen less often count as if they were seen so often: few records say more."""


def with_unseen(avalanches: Avalanches, limit: Floats) -> Avalanches:
    """The same path with the avalanches that stopped above `limit` (m) `[n_groups]`, nan: none.

    Nothing changes where the rate is not that of the records.
    """
    volumes = avalanches.volumes
    if not volumes.seen_only or np.isnan(limit).all():
        return avalanches
    share = volumes.share / np.maximum(chance_seen(avalanches, limit), LEAST_SEEN)
    whole = share.sum(axis=1)
    more = replace(volumes, rate=volumes.rate * whole, share=share / whole[:, None])
    return replace(avalanches, volumes=replace(more, seen_only=False))


def chance_seen(avalanches: Avalanches, limit: Floats) -> Floats:
    """Chance that an avalanche of each volume stops below `limit` `[n_groups]`, or leaves.

    `[n_parameters, n_volumes]`.
    """
    smooth = avalanches.site.smooth
    place = np.array([smooth.x_min if np.isnan(z) else release_place(smooth, z) for z in limit])
    if avalanches.sigma_m is not None:
        chance = passing_in_metres(avalanches)(place[avalanches.group])
    else:
        falling, broken, _ = stops(avalanches.curves)
        mu = np.array(
            [
                [np.inf if np.isnan(z) else inverse(curve, gap, x) for curve, gap in rows]
                for z, x, rows in zip(limit, place, map(zip, falling, broken), strict=True)
            ]
        )
        chance = friction_below(avalanches, mu[avalanches.group])
    return np.asarray(np.einsum("pcv,c->pv", chance, avalanches.class_share))
