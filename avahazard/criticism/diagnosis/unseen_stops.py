"""Whether an effect on the motion only makes up for avalanches that nobody saw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avahazard.criticism.diagnosis.refits import Refit, refit_side_by_side
from avahazard.criticism.diagnosis.verdict import least_evidence
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition, MotionEffect, of_kind
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations

SURE = 30.0
"""Nats that a leader may lack at most, for a limit that is needless and a gain taken too low."""


def by_what_is_seen(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    fits: Mapping[str, Refit],
    leader: str,
    screening: Screening,
) -> str | None:
    """The effect on what is seen that leaves the leader, on the motion, too little evidence.

    Where short runouts are missing, the stops of each path are bunched as by a force that holds
    back the fast. So such a force must earn its evidence where sight may be limited too. None
    where it does, where sight is known, or where the leader is not on the motion. Where a limit's
    best fit gains so little that it could not take that evidence, no fit is made.
    """
    motions = of_kind(fits[leader].posterior.effects, MotionEffect)
    sight = [c for c in screening.candidates if c.definition.says_what_is_seen]
    if leader not in [e.key for e in motions] or not sight:
        return None
    key = sight[0].key
    if key in base.specification.effects:
        return None
    needed = least_evidence(find_definition(leader, own))
    gained = fits[leader].evidence - base.evidence
    if gained - max(sight[0].gain, 0.0) > needed + SURE:
        return None
    asked = [(1, key)] if key in fits else [(1, key), (0, key)]
    both, *found = refit_side_by_side(observations, own, [base, fits[leader]], asked)
    (alone,) = found or [fits[key]]
    return None if both.evidence - alone.evidence > needed else key
