"""Effects on the record: what was written down is not where the block stopped."""

from __future__ import annotations

import numpy as np

from avahazard.synth.world import World


def observation_limit(world: World, strength: float) -> dict[str, object]:
    """Short runouts were not seen, and no `observed_below_m` tells so."""
    share = 0.35 * strength
    if share > 0.0:
        world.unseen_share, world.limit_known = share, False
    return {"unseen_share": share}


def epoch_bias(world: World, strength: float) -> dict[str, object]:
    """Records before 1950 lie too high up the path."""
    raised, year = 50.0 * strength, 1950
    world.raised_m += np.where(world.years < year, raised, 0.0)
    return {"before_year": year, "raised_m": raised}


def leading_edge(world: World, strength: float) -> dict[str, object]:
    """The record is the front, ahead of the block by a share of the deposit length."""
    world.lead_m += 0.6 * strength * world.deposit_length_m
    return {"lead_per_deposit_length": 0.6 * strength}
