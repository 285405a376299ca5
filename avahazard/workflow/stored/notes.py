"""What whoever reads a result of a stored model must know of the model: one list for all outputs.

Tables, JSON, reports and exports of every command take their notes on the model from here; what
only some volumes, paths or return periods need is said by `hazard.notes` and `extrapolation`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

import avahazard
from avahazard.effects.site import Site
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.priors import GIVEN
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.records.crosscheck import place_fault, unseen_elevation, volume_fault
from avahazard.records.doubts import repeated, repeated_notes
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.records.path import Path, Profile
from avahazard.results.calibration import Calibration, GivenTold, PriorDominated, PriorTold
from avahazard.store.models import load_model
from avahazard.store.results import latest_calibration
from avahazard.store.session import Session
from avahazard.workflow.stored.model import version_of

FEW_EVENTS = 10
"""Events under which a model is one of its priors, whatever the chains say."""
MISFIT_M = 10.0
"""Deviation of the regularised path from its points that is worth a note."""
MISFIT_SIGMAS = 4.0
"""… where it is also that many times their error: the farthest of hundreds lies some 3 away."""


def hazard_notes(model: FittedModel) -> tuple[Note, ...]:
    """What goes with every row of `hazard` by a model."""
    return (*notes_of_fit(model), *((Note("any_volume"),) if model.ignores_volume else ()))


def notes_of_fit(model: FittedModel) -> tuple[Note, ...]:
    """The notes on a model that is loaded."""
    return model_notes(model.calibration, model.records_changed, model.version)


def notes_of(session: Session, name: str, records: Records) -> tuple[Note, ...]:
    """The notes on the model `name`, without loading its draws; `records` are those of today."""
    try:
        calibration = latest_calibration(session, name)
    except AvahazardError:  # nothing to say of a model that has not been calibrated
        return ()
    paths: Sequence[str] = load_model(session, name).specification["paths"]
    changed = True
    known = {path.path_id for path in records.paths}
    if known.issuperset(paths):
        mine = only_paths(records, tuple(paths))
        changed = data_fingerprint(mine) != calibration.data_fingerprint
    return model_notes(
        Calibration.from_dict(calibration.result), changed, version_of(calibration.settings)
    )


def model_notes(
    result: Calibration, records_changed: bool, version: str | None
) -> tuple[Note, ...]:
    """The notes on what a calibration found; `version` is that of the program that made it."""
    name, n, now = result.model, result.n_events, avahazard.__version__
    notes = [
        found.note(name)
        for found in (result.path_spread, result.heavier_tails)
        if found is not None
    ]
    if records_changed:
        notes.append(Note("stale", model=name))
    if not result.diagnostics.converged:
        notes.append(Note("unconverged", model=name))
    if n < FEW_EVENTS:
        notes.append(Note("few_events", model=name, n=n))
    given, dominated = result.given_priors or {}, result.prior_dominated or {}
    notes += prior_notes(name, given, result.prior, dominated)
    notes += result.of_records or ()
    if "speed_sigma" in result.parameters:
        notes.append(Note("other_speeds", model=name))
    if version is not None and version != now:
        notes.append(Note("older_version", model=name, version=version, now=now))
    return tuple(notes)


def prior_notes(
    name: str,
    given: Mapping[str, GivenTold],
    prior: PriorTold | None,
    dominated: Mapping[str, PriorDominated],
) -> list[Note]:
    """Where the priors are not the program's own, and which parameters they dominate."""
    notes = [found.note(name, key) for key, found in given.items()]
    if prior is not None and not prior.source.startswith(GIVEN):
        notes.append(Note("prior_from", model=name, source=prior.source))
    return notes + [found.note(name, key) for key, found in dominated.items()]


def volume_notes(model: FittedModel, name: str) -> tuple[Note, ...]:
    """That its volumes are not taken for lognormal, where friction goes by volumes with errors."""
    volumes = model.observations.volumes
    if not LAWS[model.specification.law].uses_volume or not np.any(volumes.sd > 0.0):
        return ()
    if volumes.population.shape is not None:
        return (Note("volume_shape", model=name),)
    if np.isinf(volumes.largest):
        return ()
    return (Note("largest_volume", model=name, largest=float(f"{volumes.largest:.2g}")),)


def record_notes(records: Records, sites: Sequence[Site]) -> tuple[Note, ...]:
    """Paths that miss their terrain, events that cannot be true, or are there twice, unseen stops.

    An import refuses the second; a database of an earlier version may hold them.
    """
    profiles = {profile.path_id: profile for profile in records.profiles}
    paths = {path.path_id: path for path in records.paths}
    return (
        *_misfits(profiles, sites),
        *_contradictions(records.events, paths, profiles),
        *_above_limits(records.events, paths, profiles),
        *repeated_notes(repeated(records.events)),
    )


def _misfits(profiles: Mapping[str, Profile], sites: Sequence[Site]) -> Iterator[Note]:
    for path_id, site in {site.path.path_id: site for site in sites}.items():
        profile, smooth = profiles.get(path_id), site.smooth
        if profile is None:  # a straight line has no points to miss
            continue
        away = np.abs(smooth.height(profile.x_m) - profile.y_m)
        k = int(np.argmax(away))
        if away[k] > max(MISFIT_M, MISFIT_SIGMAS * smooth.sigma_m):
            yield Note("misses_points", path_id, away=float(away[k]), x=float(profile.x_m[k]))


def _contradictions(
    events: Sequence[Event], paths: Mapping[str, Path], profiles: Mapping[str, Profile]
) -> Iterator[Note]:
    for event in events:
        fault = volume_fault(event)
        profile = profiles.get(event.path_id or "")
        if fault is None and profile is not None:
            fault = place_fault(event, paths.get(profile.path_id), profile)
        if fault is not None:
            values = dict(zip(("column", "value", "accepted"), fault, strict=True))
            yield Note("contradicts_itself", event.event_id, **values)


def _above_limits(
    events: Sequence[Event], paths: Mapping[str, Path], profiles: Mapping[str, Profile]
) -> Iterator[Note]:
    above: dict[str, list[tuple[float, str]]] = {}
    for event in events:
        path = paths.get(event.path_id or "")
        if path is None:
            continue
        elevation = unseen_elevation(event, path, profiles.get(path.path_id))
        if elevation is not None:
            above.setdefault(path.path_id, []).append((elevation, event.event_id))
    for path_id, stops in above.items():
        stops.sort(reverse=True)
        yield Note(
            "above_limit",
            path_id,
            n=len(stops),
            limit=paths[path_id].observed_below_m,
            events=[event_id for _, event_id in stops],
            elevation=stops[0][0],
        )
