"""Calibrated models in and out of the database."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.fitting.refinement import refined_grids
from avahazard.inference.likelihood.assemble import build_effects, definitions_of, find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.given_prior import GivenPrior
from avahazard.inference.model.law_prior import prior_from_document
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import MethodName, Specification
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.inference.samplers.calibrated import Calibrated
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.calibration import Calibration
from avahazard.store.calibrations import latest_calibration, save_calibration
from avahazard.store.draws import load_draws
from avahazard.store.models import StoredModel, load_model, save_model
from avahazard.store.records import load_records
from avahazard.store.session import Session, reading
from avahazard.workflow.provenance import surroundings

COORDINATE, OFFSET = "coordinate:", "offset:"
"""How the draws of coordinates and path offsets are told from readable ones in the store."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredFit:
    """A stored model, fitted to the records that it was calibrated on as they are now.

    `records` are all of the database, `training` those of the calibration: on `paths`, none: all.
    `own` are definitions from the user's file, given again; `version` of the program made it.
    """

    name: str
    parent: str | None
    model: FittedModel
    facts: dict[str, Facts]
    paths: tuple[str, ...]
    own: tuple[Definition, ...]
    fingerprint: str
    result: Calibration
    records: Records
    training: Records
    version: str | None = None

    @property
    def specification(self) -> Specification:
        """What the model is made of."""
        return self.model.specification

    @property
    def definitions(self) -> tuple[Definition, ...]:
        """What its effects are."""
        return definitions_of(self.specification, self.own)

    @property
    def method(self) -> MethodName:
        """The method of the calibration."""
        return self.model.method

    def on(self, events: Sequence[Event]) -> FittedModel:
        """The model on other events of the database's paths.

        Their volumes are read in the light of those that it was calibrated on.
        """
        records = Records(self.records.paths, self.records.profiles, tuple(events))
        return self.model.on(build_observations(records, self.model.observations))

    @property
    def records_changed(self) -> bool:
        """Whether the records are others than the model was calibrated on."""
        return data_fingerprint(self.training) != self.fingerprint


def save_calibrated(
    session: Session,
    found: Calibrated,
    result: Calibration,
    *,
    paths: tuple[str, ...] = (),
    effect_file: str | None = None,
) -> None:
    """Store a model with its calibration in the transaction of `session`.

    `paths` are those that it was calibrated on, none: all; `effect_file` is the text of the
    user's effects. Raises `AvahazardError` for a taken name or a
    parent that is not there.
    """
    name, document = result.model, result.to_dict()
    model, by_chain = found.model, found.chains.draws.shape[:2]
    slots = [slot.name for slot in model.posterior.layout.slots]
    draws = {key: found.chains.draws[..., k] for k, key in enumerate(found.chains.names)}
    draws |= {f"{COORDINATE}{s}": model.draws[:, k].reshape(by_chain) for k, s in enumerate(slots)}
    draws |= {f"{OFFSET}{path}": v.reshape(by_chain) for path, v in model.offsets.items()}
    specification = {
        "specification": asdict(model.specification),
        "facts": found.facts,
        "method": model.method,
        "paths": paths,
        "grids": refined_grids(model.posterior),
        "slots": slots,
    }
    save_model(session, name, specification, parent=result.parent, effect_file=effect_file)
    save_calibration(
        session,
        name,
        settings={
            "method": model.method,
            "chains": by_chain[0],
            "draws": by_chain[1],
            "made_with": surroundings().to_dict(),
        },
        seed=result.seed,
        data_fingerprint=result.data_fingerprint,
        diagnostics=document["diagnostics"],
        converged=result.diagnostics.converged,
        result=document,
        draws=draws,
    )


def load_stored(database: str, name: str, own: Sequence[Definition] = ()) -> StoredFit:
    """The model `name` with the records of the database, all of one moment.

    `own` are the effects of the user's file, which is never run from the database. Raises
    `AvahazardError` where there is no such model, its own effects are not given, or there is
    nothing left of the records that it was calibrated on.
    """
    with reading(database) as session:
        model = load_model(session, name)
        calibration = latest_calibration(session, name)
        draws = {key: v.ravel() for key, v in load_draws(session, calibration.id).items()}
        records = load_records(session)
    kept = model.specification
    fields = kept["specification"]
    specification = Specification(
        **{
            **fields,
            "effects": tuple(fields["effects"]),
            "prior": prior_from_document(fields.get("prior")),
            "given": tuple(GivenPrior(**told) for told in fields.get("given", ())),
        }
    )
    _require_own(model, specification, own)
    paths = tuple(kept["paths"])
    training = only_paths(records, paths)
    posterior = Posterior(
        build_observations(training),
        specification,
        build_effects(specification, kept["facts"], own),
        {key: tuple(grid) for key, grid in kept["grids"].items()},
    )
    fitted = fitted_model(
        posterior,
        kept["slots"],
        np.column_stack([draws[f"{COORDINATE}{slot}"] for slot in kept["slots"]]),
        {k.removeprefix(OFFSET): v for k, v in draws.items() if k.startswith(OFFSET)},
        kept["method"],
    )
    return StoredFit(
        name=name,
        parent=model.parent,
        # The paper's methods take volumes as exact.
        model=fitted if kept["method"] == "marginal" else fitted.on(posterior.observations),
        facts=kept["facts"],
        paths=paths,
        own=tuple(own),
        fingerprint=calibration.data_fingerprint,
        result=Calibration.from_dict(calibration.result),
        records=records,
        training=training,
        version=version_of(calibration.settings),
    )


def version_of(settings: Mapping[str, Any]) -> str | None:
    """The version of the program that made a calibration; None where it was not kept."""
    versions: dict[str, str] = (settings.get("made_with") or {}).get("versions", {})
    return versions.get("avahazard")


def load_parameter_draws(database: str, name: str) -> dict[str, Floats]:
    """Draws `[n_chains, n_draws]` of the parameters that people read, in the result's order."""
    with reading(database) as session:
        calibration = latest_calibration(session, name)
        draws = load_draws(session, calibration.id)
    return {key: draws[key] for key in calibration.result["parameters"] if key in draws}


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


def require_unchanged(stored: StoredFit) -> None:
    """Raise `AvahazardError` where the records have changed since the calibration."""
    if stored.records_changed:
        raise AvahazardError(
            f"The records have changed since {stored.name} was calibrated.",
            "Calibrate it again under another name: avahazard calibrate NAME.",
        )
