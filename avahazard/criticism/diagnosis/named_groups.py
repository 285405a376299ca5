"""Groups of events that differ: when a path, a winter or a storm is itself the answer."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.criticism.diagnosis.misstated_volumes import groups_by_misstated_volumes
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.verdict import group_comes_first, groups_earn_their_name
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations


def named_group(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    rivals: Sequence[Refit],
    screening: Screening,
    granted: Sequence[str],
) -> tuple[str, ...]:
    """The granted groups that differ most plainly, where no rival explains more; none or one key.

    They need the evidence of any cause. Groups that are too few to tell their spread are never
    named. Winters and storms, which do not come again, predict nothing: any cause comes before
    them. Beside the groups stand the errors of volumes, where these may make them up.
    """
    plan = base.posterior.plan
    lasting = [key for key, lasts in zip(plan.keys, plan.lasting, strict=True) if lasts]
    plain = [
        test
        for test in screening.groups
        if test.key in granted
        and (test.key in lasting or not rivals)
        and test.p_value <= test.level
        and find_definition(test.key, own).lacking(observations.columns, observations.sites) is None
    ]
    for test in sorted(plain, key=lambda t: -t.gain):
        if not groups_earn_their_name(observations, own, base, test.key):
            continue
        if all(group_comes_first(observations, own, base, rival, test.key) for rival in rivals):
            errors = groups_by_misstated_volumes(observations, own, base, test.key, screening)
            return (test.key, errors) if errors else (test.key,)
    return ()
