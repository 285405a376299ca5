"""Groups of events that differ: when a path, a winter or a storm is itself the answer."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.verdict import group_comes_first, groups_earn_their_name
from avahazard.criticism.screening.significance import GroupTest
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations


def named_group(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    rivals: Sequence[Refit],
    tests: Sequence[GroupTest],
    granted: Sequence[str],
) -> tuple[str, ...]:
    """The granted groups that differ most plainly, where no rival explains more; none or one key.

    Groups that are too few to tell their spread are never named. Winters and storms, which do not
    come again, predict nothing: any cause comes before them, and they need the same evidence.
    """
    plan = base.posterior.plan
    lasting = [key for key, lasts in zip(plan.keys, plan.lasting, strict=True) if lasts]
    plain = [
        test
        for test in tests
        if test.key in granted
        and (test.key in lasting or not rivals)
        and test.p_value <= test.level
        and find_definition(test.key, own).lacking(observations.columns, observations.sites) is None
    ]
    for test in sorted(plain, key=lambda t: -t.gain):
        if test.key not in lasting and not groups_earn_their_name(
            observations, own, base, test.key
        ):
            continue
        if all(group_comes_first(observations, own, base, rival, test.key) for rival in rivals):
            return (test.key,)
    return ()
