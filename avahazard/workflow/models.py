"""What is stored of models: all of them in short, and one in full."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.observations import build_observations
from avahazard.inference.sampling import calibrate_model
from avahazard.records.errors import AvahazardError
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.base import Report, Rows, silent
from avahazard.results.calibration import Calibration
from avahazard.results.models import Difference, ModelSummary, Provenance, Rerun, Surroundings
from avahazard.store.records import load_records
from avahazard.store.results import list_models, load_calibrated
from avahazard.store.session import reading
from avahazard.workflow.calibrate import start_from
from avahazard.workflow.stored import (
    load_parameter_draws,
    load_stored,
    notes_of,
    require_unchanged,
    surroundings,
)

IN_SHORT = ("model", "parent", "law", "scatter", "distribution", "method", "effects", "n_events")


def show_models(database: str) -> Rows[ModelSummary]:
    """One entry a model, oldest first: what it is made of, whether it converged, and when.

    Raises `AvahazardError` where the database cannot be used.
    """
    rows = []
    with reading(database) as session:
        for model in list_models(session):
            found = {key: model.result[key] for key in IN_SHORT}
            found["converged"] = model.result["diagnostics"]["converged"]
            rows.append(ModelSummary.from_dict(found | {"created": _utc(model.created)}))
    return Rows(rows)


def show_model(database: str, name: str) -> Calibration:
    """A model's calibration, and `created`, the time in UTC.

    Raises `AvahazardError` where there is no such model.
    """
    with reading(database) as session:
        model = load_calibrated(session, name)
        known = notes_of(model, load_records(session))
    found = Calibration.from_dict(model.result)
    # Those of the calibration and those of today; the former have not converged in figures.
    notes = [n for n in known if n.key != "unconverged" and n not in found.notes]
    return replace(found, notes=(*found.notes, *notes), created=_utc(model.created))


def _utc(time: dt.datetime) -> str:
    return f"{time.isoformat(timespec='seconds')}Z"


def show_provenance(database: str, name: str) -> Provenance:
    """What is needed to make the model `name` again.

    Raises `AvahazardError` where there is no such model.
    """
    with reading(database) as session:
        model = load_calibrated(session, name)
        records = load_records(session)
    kept, settings = model.specification, model.settings
    made_with = settings.get("made_with")
    training = only_paths(records, model.paths)
    return Provenance(
        model=name,
        parent=model.parent,
        created=_utc(model.created),
        data_fingerprint=model.result["data_fingerprint"],
        records_changed=data_fingerprint(training) != model.result["data_fingerprint"],
        specification=kept["specification"],
        method=kept["method"],
        paths=model.paths,
        chains=settings["chains"],
        draws=settings["draws"],
        seed=model.result["seed"],
        effect_sha256=model.effect_sha256,
        made_with=None if made_with is None else Surroundings.from_dict(made_with),
        now=surroundings(),
    )


def rerun(
    database: str, name: str, *, effect_files: Sequence[Path] = (), report: Report = silent
) -> Rerun:
    """Calibrate the model `name` again and hold every draw against the stored ones.

    Raises `AvahazardError` where there is no such model, its records have changed, or the files of
    its own effects are missing or others.
    """
    stored, records = load_stored(database, name, effect_files)
    own = stored.definitions
    require_unchanged(stored)
    kept = load_parameter_draws(database, name)
    if "speed_sigma" in kept:
        raise AvahazardError(
            f"{name} was calibrated with the error of speeds of an earlier version (speed_sigma).",
            "Calibrate a new model: this version knows the scatter of friction along tracks.",
        )
    observations = build_observations(
        only_paths(records, stored.paths), forward=stored.specification.forward
    )
    start, told = None, stored.calibration
    if told.parent is not None:
        child = assemble(observations, stored.specification, stored.facts, own)
        start = start_from(load_stored(database, told.parent, own=own)[0], child)
    found = calibrate_model(
        observations,
        stored.specification,
        stored.facts,
        method=stored.method,
        n_chains=told.chains,
        n_draws=told.draws,
        seed=told.seed,
        own=own,
        start=start,
        progress=lambda share: report(f"Calibrating {name} again", share, 1.0),
    )
    again = dict(zip(found.chains.names, np.moveaxis(found.chains.draws, -1, 0), strict=True))
    differences = {
        key: Difference(
            float(kept[key].mean()),
            float(again[key].mean()),
            float(np.max(np.abs(kept[key] - again[key]))),
        )
        for key in kept
        if not np.array_equal(kept[key], again[key])
    }
    return Rerun(name, not differences, len(kept), differences, _notes(database, name))


def _notes(database: str, name: str) -> tuple[str, ...]:
    """What may make a difference: other versions than at the time."""
    found = show_provenance(database, name)
    if found.made_with is None:
        return ("the versions that the model was made with were not kept.",)
    before, now = found.made_with.versions, found.now.versions
    return tuple(
        f"{package} was {before.get(package, 'not there')}, and is {now[package]} now."
        for package in now
        if before.get(package) != now[package]
    )
