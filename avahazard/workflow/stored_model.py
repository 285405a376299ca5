"""Calibrated models in and out of the database, and their posteriors rebuilt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import build_effects, find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import MethodName, Specification
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.fingerprint import data_fingerprint
from avahazard.store.calibrations import latest_calibration, save_calibration
from avahazard.store.draws import load_draws
from avahazard.store.models import StoredModel, load_model, save_model
from avahazard.store.records import load_records
from avahazard.store.session import reading, writing
from avahazard.workflow.calibrated import Calibrated
from avahazard.workflow.one_path import find_path

Floats = NDArray[np.float64]

COORDINATE, OFFSET = "coordinate:", "offset:"
"""How the draws of coordinates and path offsets are told from readable ones in the store."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredFit:
    """A stored model with its draws, all chains in a row.

    `coordinates` `[n_draws, n_slots]` are named by `slots`, in the order of the layout at
    calibration; `offsets` `[n_draws]` of log friction by path. `paths` are those that it was
    calibrated on, none: all. `own` are definitions from the user's file, given again. σ of
    `method` metropolis is in metres of recorded elevation, not of friction. `result` is the
    document of the calibration.
    """

    name: str
    parent: str | None
    specification: Specification
    facts: dict[str, Facts]
    method: MethodName
    paths: tuple[str, ...]
    slots: tuple[str, ...]
    coordinates: Floats
    offsets: dict[str, Floats]
    grids: dict[str, tuple[float, ...]]
    own: tuple[Definition, ...]
    fingerprint: str
    result: dict[str, Any]


def save_calibrated(
    database: str,
    found: Calibrated,
    document: dict[str, Any],
    *,
    paths: tuple[str, ...] = (),
    effect_file: str | None = None,
) -> None:
    """Store a model with its calibration: all of it, or nothing.

    `document` is its `result_document`; `paths` those it was calibrated on, none: all;
    `effect_file` the text of the user's effects. Raises `AvahazardError` for a taken name or a
    parent that is not there.
    """
    name = document["model"]
    n_chains, n_draws, n_slots = found.coordinates.shape
    draws = {key: found.chains.draws[..., k] for k, key in enumerate(found.chains.names)}
    draws |= {f"{COORDINATE}{found.slots[k]}": found.coordinates[..., k] for k in range(n_slots)}
    draws |= {f"{OFFSET}{path_id}": values for path_id, values in found.offsets.items()}
    specification = {
        "specification": asdict(found.specification),
        "facts": found.facts,
        "method": found.method,
        "paths": paths,
        "grids": found.grids,
        "slots": found.slots,
    }
    with writing(database) as session:
        save_model(session, name, specification, parent=document["parent"], effect_file=effect_file)
        save_calibration(
            session,
            name,
            settings={"method": found.method, "chains": n_chains, "draws": n_draws},
            seed=document["seed"],
            data_fingerprint=document["data_fingerprint"],
            diagnostics=document["diagnostics"],
            converged=document["diagnostics"]["converged"],
            result=document,
            draws=draws,
        )


def load_stored(
    database: str, name: str, own: Sequence[Definition] = ()
) -> tuple[StoredFit, Records]:
    """The model `name` and all records of the database, both of one moment.

    `own` are the effects of the user's file, which is never run from the database. Raises
    `AvahazardError` where there is no such model, or its own effects are not given.
    """
    with reading(database) as session:
        model = load_model(session, name)
        calibration = latest_calibration(session, name)
        draws = {key: v.ravel() for key, v in load_draws(session, calibration.id).items()}
        records = load_records(session)
    kept = model.specification
    fields = kept["specification"]
    specification = Specification(**{**fields, "effects": tuple(fields["effects"])})
    _require_own(model, specification, own)
    slots = tuple(kept["slots"])
    fit = StoredFit(
        name=name,
        parent=model.parent,
        specification=specification,
        facts=kept["facts"],
        method=kept["method"],
        paths=tuple(kept["paths"]),
        slots=slots,
        coordinates=np.column_stack([draws[f"{COORDINATE}{slot}"] for slot in slots]),
        offsets={
            key.removeprefix(OFFSET): values
            for key, values in draws.items()
            if key.startswith(OFFSET)
        },
        grids={key: tuple(grid) for key, grid in kept["grids"].items()},
        own=tuple(own),
        fingerprint=calibration.data_fingerprint,
        result=calibration.result,
    )
    return fit, records


def load_parameter_draws(database: str, name: str) -> dict[str, Floats]:
    """Draws `[n_draws]` of the parameters that people read, in the order of the document."""
    with reading(database) as session:
        calibration = latest_calibration(session, name)
        draws = load_draws(session, calibration.id)
    return {key: draws[key].ravel() for key in calibration.result["parameters"] if key in draws}


def _require_own(
    model: StoredModel, specification: Specification, own: Sequence[Definition]
) -> None:
    for key in specification.effects:
        try:
            find_definition(key, own)
        except AvahazardError as error:
            if model.effect_file is None:
                raise
            raise AvahazardError(
                f"The model {model.name} has the effect '{key}' from its user's file.",
                "Name that file again: --effect-file FILE. It is never run from the database.",
            ) from error


def posterior_for(
    stored: StoredFit, records: Records, prior: Observations | None = None
) -> tuple[Observations, Posterior]:
    """The observations of `records`, and the model's posterior over it.

    `records` are those of the calibration (`training_records`), or others, whose volumes are
    then read in the light of `prior`, the observations of the calibration.
    """
    observations = build_observations(records, prior)
    effects = build_effects(stored.specification, stored.facts, stored.own)
    return observations, Posterior(observations, stored.specification, effects, stored.grids)


def coordinates_for(stored: StoredFit, posterior: Posterior) -> Floats:
    """The model's draws `[n_draws, n_slots]` in the order of the slots of `posterior`.

     observations with speeds has a slot for their scatter that one without has not; where the model
    was calibrated without, it stays at the mean of its prior.
    """
    place = {slot: k for k, slot in enumerate(stored.slots)}
    columns = [
        stored.coordinates[:, place[slot.name]]
        if slot.name in place
        else np.full(len(stored.coordinates), slot.mean)
        for slot in posterior.layout.slots
    ]
    return np.column_stack(columns)


def training_records(stored: StoredFit, records: Records) -> Records:
    """Those of the database's records that the model is calibrated on, as they are now."""
    return only_paths(records, stored.paths)


def records_changed(stored: StoredFit, records: Records) -> bool:
    """Whether the database's records are others than the model was calibrated on."""
    return data_fingerprint(training_records(stored, records)) != stored.fingerprint


def require_unchanged(stored: StoredFit, records: Records) -> None:
    """Raise `AvahazardError` where the records have changed since the calibration."""
    if records_changed(stored, records):
        raise AvahazardError(
            f"The records have changed since {stored.name} was calibrated.",
            "Calibrate it again under another name: avahazard calibrate NAME.",
        )


def only_paths(records: Records, paths: Sequence[str]) -> Records:
    """The records of these paths; all where none are named.

    Raises `AvahazardError` for an unknown path, and where the paths have no events.
    """
    if not paths:
        return records
    wanted = {find_path(records, path_id).path_id for path_id in paths}
    events = tuple(e for e in records.events if e.path_id in wanted)
    if not events:
        raise AvahazardError(
            f"There are no events on {', '.join(paths)}.", "Import some: avahazard import FOLDER."
        )
    names = {e.event_id for e in events}
    return Records(
        tuple(p for p in records.paths if p.path_id in wanted),
        tuple(p for p in records.profiles if p.path_id in wanted),
        events,
        tuple(s for s in records.speeds if s.event_id in names),
    )
