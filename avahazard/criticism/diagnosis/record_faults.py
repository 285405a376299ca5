"""What faults of the records, rather than of the model, could explain."""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import logsumexp
from scipy.stats import pearsonr

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.naming import MARGIN, acts_on_motion
from avahazard.criticism.diagnosis.refits import (
    Question,
    Refit,
    effect_on,
    refit_with,
    refit_without,
)
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import VOLUME, in_logs, number_column
from avahazard.effects.effect import Definition, VolumeErrorEffect
from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.model.observations import ELEVATION, PLACE
from avahazard.inference.model.volumes import VolumeNodes, bounded, told_by, within_paths
from avahazard.notes import Note
from avahazard.records.crosscheck import dwarfing

OF_THE_VOLUME = ("law", "scatter")
"""Settings of the model that say how friction goes by volume."""
OVERSTATED = (0.03, 0.1, 0.2)
"""Shares of the recorded volumes that are tried as larger than any true one."""
BY_CHANCE = 0.01
"""A column goes with the volumes where chance alone would not let it in more cases."""

SURE, NEARLY_SURE = 30.0, 5.0
"""Nats that a leader may lack at most, for a limit that is needless and a gain taken too low; and
where that limit was fitted by itself."""
SPEEDS_OFF, MOST_OFF = 0.03, 0.2
"""Standard deviation of the log of a factor that all measured speeds may have in common, and the
most that it is."""
MOST_SCATTERS = 4.0
"""Scatters off, from which on a record is suspect."""
FEW_SUSPECTS, HALF = 3, 0.5
"""Of so many suspect records on, that all are on a path with under half of all is no chance."""
MOST_ERRORS = 2.5
"""Errors of the record off the nearest stop, from which on it cannot be meant."""


def by_misstated_volumes(question: Question, leader: str) -> str | None:
    """The effect on the volumes' errors that leaves the leader too little evidence.

    Larger errors than stated bend the law and scatter friction, and a column that goes with the
    volume then informs about it (docs/theory/criticism.md). None where the leader, or the smooth of
    a column as a stand-in for a cause, keeps its evidence, or is another kind.
    """
    definition = question.base.definition(leader)
    key = _errors_of_volumes(question)
    if key is None or key in question.base.specification.effects:
        return None
    by_volume = definition.changes is not None and definition.changes.field in OF_THE_VOLUME
    if by_volume or in_logs(definition.column or ""):
        return None if _gain_of_volume(question, leader, key) > MARGIN else key
    observations = question.base.observations
    stand_in = stand_in_for_volume(observations.columns, definition)
    if stand_in is None:
        return None
    volumes = told_by(observations.volumes, stand_in)
    beside, without = _evidence_with(question, leader, key, volumes)
    return None if beside - without > MARGIN else key


def _gain_of_volume(question: Question, leader: str, key: str) -> float:
    """Evidence (nats) of a law or a scatter beside the effect `key` on the volumes' errors.

    Where it is over `MARGIN`, either is the mean over some largest volumes, which bend the law.
    """
    alone = question.fits.get(key) or refit_with(question.base, key)
    both = refit_with(question.fits[leader], key)
    if both.evidence - alone.evidence <= MARGIN:
        return both.evidence - alone.evidence
    observations = question.base.observations
    recorded = observations.columns.log_volume
    pairs = [(both.evidence, alone.evidence)]
    for share in OVERSTATED:
        largest = float(np.exp(np.nanquantile(recorded, 1.0 - share)))
        volumes = bounded(observations.volumes, largest)
        pairs.append(_evidence_with(question, leader, key, volumes))
    beside, without = zip(*pairs, strict=True)
    return float(logsumexp(beside) - logsumexp(without))


def _evidence_with(
    question: Question, leader: str, key: str, volumes: VolumeNodes
) -> tuple[float, float]:
    """Evidence with effect `key` on other volumes: of the leader's model, and of the base."""
    on = replace(question.base.observations, volumes=volumes)
    without = refit_with(question.base, key, on=on).evidence
    return refit_with(question.fits[leader], key, on=on).evidence, without


def stand_in_for_volume(columns: EventColumns, definition: Definition) -> Floats | None:
    """The column `[n_events]`, or its log, of an effect by one that goes with the recorded volumes.

    None for the volume itself, and where chance would make as much of it, within paths, in one of a
    hundred cases.
    """
    name = definition.column or definition.reads
    values = None if name is None or name == VOLUME else number_column(columns, name)
    if values is None:
        return None
    if np.nanmin(values) > 0.0:
        values = np.log(values)
    away = within_paths(np.array([values, columns.log_volume]), columns.path_index)
    away = away[:, np.isfinite(away).all(axis=0)]
    if not away.size or np.any(np.ptp(away, axis=1) == 0.0):
        return None
    return values if pearsonr(*away).pvalue < BY_CHANCE else None


def groups_by_misstated_volumes(question: Question, groups: str) -> str | None:
    """The effect on the volumes' errors that leaves groups (a key) too little evidence, or None."""
    key = _errors_of_volumes(question)
    if key is None:
        return None
    wider = refit_with(question.base, key)
    return None if wider.evidence - refit_without(wider, groups).evidence > MARGIN else key


def _errors_of_volumes(question: Question) -> str | None:
    """The candidate that scales the errors of the volumes, if there is one."""
    on, candidates = question.base.observations, question.screening.candidates
    scales = (c for c in candidates if isinstance(effect_on(c.definition, on), VolumeErrorEffect))
    return next((candidate.key for candidate in scales), None)


def by_undetected_stops(question: Question, leader: str) -> str | None:
    """The detection limit that leaves the leader, on the motion, too little evidence.

    None where it leaves enough, where the limit is known, or where the leader is not on the motion.
    A limit that by itself gains too little to take that evidence is not fitted beside the leader.
    """
    base, fits = question.base, question.fits
    limits = [c for c in question.screening.candidates if c.definition.says_what_is_seen]
    if not acts_on_motion(fits[leader], leader) or not limits:
        return None
    key = limits[0].key
    if key in base.specification.effects:
        return None
    first = fits[leader]
    if first.evidence - base.evidence - max(limits[0].gain, 0.0) > MARGIN + SURE:
        return None
    alone = fits.get(key) or refit_with(base, key)
    # What its parameters cost where it is needless is no more than they cost where it is not.
    cost = alone.log_likelihood - base.log_likelihood - (alone.evidence - base.evidence)
    if first.evidence - cost - alone.evidence > MARGIN + NEARLY_SURE:
        return None
    both = refit_with(first, key)
    return None if both.evidence - alone.evidence > MARGIN else key


def by_speeds_off(question: Question, leader: str) -> float | None:
    """The factor common to all measured speeds that explains more than the leader does.

    None where the model with such a factor does not lead the force, by itself and beside the
    factor, by `MARGIN`; where no speeds are measured; or where the leader is not on the motion.
    """
    base, fit = question.base, question.fits[leader]
    if not base.observations.speeds or not acts_on_motion(fit, leader):
        return None

    def with_factor(model: Refit, off: float, least: float) -> tuple[float, float]:
        """Log likelihood and evidence, this where the likelihood reaches `least`."""
        factor, tracks = np.exp(-off), base.observations.speeds
        true = (replace(t, speed=factor * t.speed, sigma=factor * t.sigma) for t in tracks)
        on = replace(base.observations, speeds=tuple(true))
        added = -off * sum(len(t.speed) for t in tracks) - 0.5 * (off / SPEEDS_OFF) ** 2
        found = refit_with(model, on=on, least=least - added)
        return found.log_likelihood + added, found.evidence + added

    found = minimize_scalar(
        lambda off: -with_factor(base, off, np.inf)[0], bounds=(-MOST_OFF, MOST_OFF),
        method="bounded", options={"xatol": 0.3 * SPEEDS_OFF},
    )  # fmt: skip
    off = float(found.x)
    without = with_factor(base, off, fit.evidence + MARGIN)[1]
    if without - fit.evidence < MARGIN or without - with_factor(fit, off, -np.inf)[1] < MARGIN:
        return None
    return float(np.exp(off))


def explained_by_record_faults(question: Question, key: str) -> tuple[str, ...]:
    """Effects on the record that leave candidate `key` too little evidence over the base."""
    found = (by_undetected_stops(question, key), by_misstated_volumes(question, key))
    return tuple(other for other in found if other is not None)


def suspects(base: Refit) -> tuple[str, ...]:
    """Events whose volume dwarfs all others, then those more than `MOST_SCATTERS` off, worst first.

    A slip of units in a volume bends the law until its event lies on it.
    """
    posterior = base.posterior
    location, scatter = posterior.location_and_scatter(base.mode.u)
    friction = likely_friction(posterior.nodes.at(base.mode.u), posterior.layout.log_scatter)
    asked = np.log(friction) if posterior.layout.log_scatter else friction
    # Of the kind of avalanche that suits the event best.
    by_kind = len(location), -1, posterior.observations.volumes.volume.shape[1]
    off = np.abs(asked[:, None] - location.reshape(by_kind).mean(axis=2))
    z = np.nan_to_num(np.min(off, axis=1) / scatter.mean(axis=1))
    order = np.argsort(-z, kind="stable")
    columns = posterior.observations.columns
    found = [*dwarfing(columns.log_volume), *(i for i in order if z[i] > MOST_SCATTERS)]
    return tuple(dict.fromkeys(columns.event_id[i] for i in found))


def impossible_stops(base: Refit) -> tuple[str, ...]:
    """Events recorded within a jump of F(μ), over `MOST_ERRORS` errors from both of its ends."""
    observations, table = base.observations, base.posterior.nodes.predicted_at(base.mode.u)
    found = []
    for i in np.flatnonzero(np.isin(observations.kind, (ELEVATION, PLACE))):
        record, stop = table.record[i], observations.observed[i]
        reach = MOST_ERRORS * table.sigma[i]
        low = np.minimum(record[1:], record[:-1])
        high = np.maximum(record[1:], record[:-1])
        discontinuous = table.curve[i].discontinuous
        inside = (low <= stop) & (stop <= high)
        near = (low - reach <= stop) & (stop <= high + reach)
        ends = np.min(np.abs(record - stop)) <= reach
        if np.any(inside & discontinuous) and not np.any(near & ~discontinuous) and not ends:
            found.append(observations.columns.event_id[i])
    return tuple(found)


def on_one_path(base: Refit) -> tuple[Note, ...]:
    """A note where all suspect records are on one path, which has fewer than half of all.

    Its profile may be wrong.
    """
    columns = base.posterior.observations.columns
    found = {*suspects(base), *impossible_stops(base)}
    on = columns.path_index[np.isin(columns.event_id, [*found])]
    if len(on) < FEW_SUSPECTS or np.ptp(on) or on[0] < 0:
        return ()
    if np.mean(columns.path_index == on[0]) > HALF:
        return ()
    return (Note("suspects_on", path=columns.paths[on[0]], n=len(on)),)
