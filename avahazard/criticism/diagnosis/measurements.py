"""What to measure next: how many nats a measurement would part two explanations by."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.confounding import explained
from avahazard.criticism.diagnosis.friction_variance import friction_variance
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.speed_measurement import speed_gain
from avahazard.effects.effect import FrictionEffect, of_kind
from avahazard.message import message
from avahazard.results.base import Rows
from avahazard.results.diagnosis import Measurement

N_MIDDLES, N_TRACKS, N_PLACES = 20, 5, 8
"""Events with a speed at mid-track, or with that many along the whole track."""
N_EVENTS = 50

RUNOUTS = message("runouts of {n} more events on paths like these")
MID_TRACK = message("speeds at mid-track on {n} events")
WHOLE_TRACK = message("speeds along the whole track of {n} events")
FURTHER_PATH = message("{n} events on a further path, like the one where they part most")
UNLINKED = message("{n} events in which what {one} and {other} go by do not go together")


def measurement_gains(first: Refit, second: Refit, seed: int = 0) -> Rows[Measurement]:
    """Measurements that part two fits, best first, each with its expected gain (nats).

    Without profiles only further events can be measured.
    """
    gain = record_gain(first, second)
    text = RUNOUTS.format(n=N_EVENTS)
    found = {text: N_EVENTS * float(np.mean(gain))}
    if first.posterior.observations.sites:
        groups = first.posterior.observations.columns.path_index
        best = max(float(np.mean(gain[groups == k])) for k in np.unique(groups))
        found |= {
            MID_TRACK.format(n=N_MIDDLES): speed_gain(first, second, N_MIDDLES, 1, seed),
            WHOLE_TRACK.format(n=N_TRACKS): speed_gain(first, second, N_TRACKS, N_PLACES, seed),
            FURTHER_PATH.format(n=N_EVENTS): N_EVENTS * best,
        }
    shifts = _column_shifts(first, second)
    if len(shifts) == 2:
        (a, shift_a), (b, shift_b) = shifts.items()
        total = friction_variance(first).total
        # The weaker must be missed: its rival then gives it up.
        apart = 0.5 * min(float(np.var(shift_a)), float(np.var(shift_b))) / float(np.median(total))
        text = UNLINKED.format(n=N_EVENTS, one=a, other=b)
        found[text] = N_EVENTS * apart
    ranked = sorted(found.items(), key=lambda item: -item[1])
    return Rows(Measurement(text, float(value)) for text, value in ranked)


def record_gain(first: Refit, second: Refit) -> Floats:
    """Expected log likelihood ratio (nats) of one more event like each `[n_events]`.

    The fits ask for different frictions; what paths differ by is not known of new ones, so only
    differences within a path tell.
    """
    gap = explained(first, second)
    groups = first.posterior.observations.columns.path_index
    for k in np.unique(groups[groups >= 0]):
        gap[groups == k] -= np.mean(gap[groups == k])
    return np.asarray(0.5 * gap**2 / friction_variance(first).total)


def _column_shifts(first: Refit, second: Refit) -> dict[str, Floats]:
    """What the effects of one fit alone do to log friction `[n_events]`.

    Only those that go by a column of the events.
    """
    shifts = {}
    for mine, other in ((first, second), (second, first)):
        values = mine.posterior.layout.effect_values(mine.mode.u)
        for effect in of_kind(mine.posterior.effects, FrictionEffect):
            if effect.key not in other.specification.effects:
                columns = effect.design(mine.posterior.observations.columns)
                shifts[effect.key] = np.asarray(columns @ values[effect.key])
    return shifts
