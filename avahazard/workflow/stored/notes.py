"""What whoever reads a result of a stored model must know of the model: one list for all outputs.

Tables, JSON, reports and exports of every command take their notes on the model from here; what
only some volumes, paths or return periods need is said by `hazard.notes` and `extrapolation`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import avahazard
from avahazard.hazard.notes import stale_words, unconverged_words
from avahazard.inference.model.priors import GIVEN
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.message import message
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.calibration import (
    PRIOR_FROM,
    Calibration,
    GivenTold,
    PriorDominated,
    PriorTold,
)
from avahazard.store.models import load_model
from avahazard.store.results import latest_calibration
from avahazard.store.session import Session
from avahazard.workflow.stored.model import version_of

FEW_ONE = message("{model} stands on 1 event only.")
FEW = message("{model} stands on {n} events only.")
OLDER = message(
    "{model} was made with version {version} of this program, which is {now} now: avahazard rerun "
    "{model} tells whether that matters."
)
OTHER_SPEEDS = message(
    "{model} was calibrated with the error of speeds of an earlier version (speed_sigma). "
    "Calibrate a new model: until then friction along its tracks scatters as the prior of "
    "track_sigma says."
)
FEW_EVENTS = 10
"""Events under which a model is one of its priors, whatever the chains say."""


def notes_of_fit(model: FittedModel) -> tuple[str, ...]:
    """The notes on a model that is loaded."""
    return model_notes(model.calibration, model.records_changed, model.version)


def notes_of(session: Session, name: str, records: Records) -> tuple[str, ...]:
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


def model_notes(result: Calibration, records_changed: bool, version: str | None) -> tuple[str, ...]:
    """The notes on what a calibration found; `version` is that of the program that made it."""
    name, notes = result.model, []
    if result.path_spread is not None:
        notes.append(result.path_spread.note(name))
    if result.heavier_tails is not None:
        notes.append(result.heavier_tails.note(name))
    if records_changed:
        notes.append(stale_words(name))
    if not result.diagnostics.converged:
        notes.append(unconverged_words(name))
    if result.n_events < FEW_EVENTS:
        words = FEW_ONE if result.n_events == 1 else FEW
        notes.append(words.format(model=name, n=result.n_events))
    notes += prior_notes(
        name, result.given_priors or {}, result.prior, result.prior_dominated or {}
    )
    notes += result.of_records or ()
    if "speed_sigma" in result.parameters:
        notes.append(OTHER_SPEEDS.format(model=name))
    if version is not None and version != avahazard.__version__:
        notes.append(OLDER.format(model=name, version=version, now=avahazard.__version__))
    return tuple(notes)


def prior_notes(
    name: str,
    given: Mapping[str, GivenTold],
    prior: PriorTold | None,
    dominated: Mapping[str, PriorDominated],
) -> list[str]:
    """Where the priors are not the program's own, and where they speak rather than the records."""
    notes = [told.note(name, key) for key, told in given.items()]
    if prior is not None and not prior.source.startswith(GIVEN):
        notes.append(PRIOR_FROM.format(model=name, source=prior.source))
    return notes + [told.note(name, key) for key, told in dominated.items()]
