"""Whether an effect, or a difference of groups, only makes up for volumes' misstated errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import logsumexp
from scipy.stats import pearsonr

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.refits import Refit, refit
from avahazard.criticism.diagnosis.verdict import MARGIN, groups_earn_their_name
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import VOLUME, number_column
from avahazard.effects.effect import Definition, VolumeErrorEffect
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.volumes import bounded, told_by, within_paths

OF_THE_VOLUME = ("law", "scatter")
"""Settings of the model that say how friction goes by volume."""
OVERSTATED = (0.03, 0.1, 0.2)
"""Shares of the recorded volumes that are tried as larger than any true one."""
BY_CHANCE = 0.01
"""A column goes with the volumes where chance alone would not let it in more cases."""


def by_misstated_volumes(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    fits: Mapping[str, Refit],
    leader: str,
    screening: Screening,
) -> str | None:
    """The effect on the volumes' errors that leaves the leader too little evidence.

    Errors larger than stated bend the law towards the mean volume and scatter friction most where
    it is steepest: another law, and another scatter, do the same. And a column that goes with the
    volume (a deposit's length) then tells more of it than the records do, and friction seems to go
    by the column. So such leaders must earn their evidence where the errors may be misstated too;
    the smooth of a column that of a cause, as there is a cause that it would stand for.
    None where it does, or is another kind.
    """
    definition = find_definition(leader, own)
    key = _errors_of_volumes(observations, screening)
    if key is None or key in base.specification.effects:
        return None
    if definition.changes is not None and definition.changes.field in OF_THE_VOLUME:
        gain = _gain_of_volume(observations, own, base, fits, leader, key)
        return None if gain > MARGIN else key
    stand_in = stand_in_for_volume(observations.columns, definition)
    if stand_in is None:
        return None
    told = replace(observations, volumes=told_by(observations.volumes, stand_in))
    beside = _with(told, own, fits[leader], key).evidence - _with(told, own, base, key).evidence
    return None if beside > MARGIN else key


def _gain_of_volume(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    fits: Mapping[str, Refit],
    leader: str,
    key: str,
) -> float:
    """Evidence (nats) of a law or a scatter beside the effect `key` on the volumes' errors.

    How far records of large volumes are overstated hangs on the largest volume that there is, which
    nobody knows: where it lies under many records, friction stops falling with what is recorded,
    as in a law with a limit. So the evidence of either is the mean over some such volumes, where
    it is over `MARGIN` without.
    """
    first = fits[leader]
    alone = fits.get(key) or _with(observations, own, base, key)
    both = _with(observations, own, first, key)
    without, beside = [alone.evidence], [both.evidence]
    if beside[0] - without[0] <= MARGIN:
        return beside[0] - without[0]
    recorded = observations.columns.log_volume
    for share in OVERSTATED:
        largest = float(np.exp(np.nanquantile(recorded, 1.0 - share)))
        limited = replace(observations, volumes=bounded(observations.volumes, largest))
        without.append(_with(limited, own, base, key).evidence)
        beside.append(_with(limited, own, first, key).evidence)
    return float(logsumexp(beside) - logsumexp(without))


def stand_in_for_volume(columns: EventColumns, definition: Definition) -> Floats | None:
    """The column `[n_events]` of an effect that goes by one which goes with the recorded volumes.

    Its log where it is positive. None for the volume itself, and where chance would make as much
    of it, within paths, in one of a hundred cases.
    """
    name = definition.column or definition.reads
    if name is None or name == VOLUME:
        return None
    values = number_column(columns, name)
    if values is None:
        return None
    if np.nanmin(values) > 0.0:
        values = np.log(values)
    away = within_paths(np.array([values, columns.log_volume]), columns.path_index)
    away = away[:, np.isfinite(away).all(axis=0)]
    if not away.size or np.any(np.ptp(away, axis=1) == 0.0):
        return None
    return values if pearsonr(*away).pvalue < BY_CHANCE else None


def groups_by_misstated_volumes(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    groups: str,
    screening: Screening,
) -> str | None:
    """The effect on the volumes' errors that leaves groups (a key) too little evidence, or None.

    Errors larger than stated make friction fall less with the volumes of a path's records than with
    the mean volumes of paths, in which errors average out. One law for both gives paths of large
    avalanches too much friction, and they seem to differ.
    """
    key = _errors_of_volumes(observations, screening)
    if key is None:
        return None
    wider = _with(observations, own, base, key)
    return None if groups_earn_their_name(observations, own, wider, groups) else key


def _errors_of_volumes(observations: Observations, screening: Screening) -> str | None:
    """The candidate that scales the errors of the volumes, if there is one."""
    candidates = screening.candidates
    return next((c.key for c in candidates if _on_volumes(c.definition, observations)), None)


def _with(observations: Observations, own: Sequence[Definition], start: Refit, key: str) -> Refit:
    return refit(observations, start.specification, start.facts, (key,), own, start)


def _on_volumes(entry: Definition, observations: Observations) -> bool:
    """Whether an effect scales the errors of the volumes."""
    if entry.changes is not None:
        return False
    facts = entry.facts(observations.columns, observations.sites)
    return isinstance(entry.build(facts), VolumeErrorEffect)
