"""Calibrated models in and out of the database."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from avahazard.arrays import Floats
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.fitting.refinement import refined_grids
from avahazard.inference.model.observations import build_observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.calibrated import Calibrated
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.calibration import Calibration
from avahazard.store.models import save_model
from avahazard.store.records import load_records
from avahazard.store.results import latest_calibration, load_draws, save_calibration
from avahazard.store.session import Session, reading
from avahazard.workflow.provenance import surroundings
from avahazard.workflow.stored.fit import COORDINATE, OFFSET, Fit, load_kept


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StoredFit(Fit):
    """A stored model, fitted to the records that it was calibrated on as they are now.

    `records` are all of the database, `training` those of the calibration: on `paths`, none: all.
    """

    parent: str | None
    facts: dict[str, Facts]
    paths: tuple[str, ...]
    records: Records
    training: Records

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
        kept = load_kept(session, name, own)
        records = load_records(session)
    training = only_paths(records, kept.paths)
    return StoredFit(
        name=name,
        parent=kept.parent,
        model=kept.on(build_observations(training)),
        facts=kept.facts,
        paths=kept.paths,
        own=kept.own,
        fingerprint=kept.fingerprint,
        result=kept.result,
        records=records,
        training=training,
        version=kept.version,
    )


def load_parameter_draws(database: str, name: str) -> dict[str, Floats]:
    """Draws `[n_chains, n_draws]` of the parameters that people read, in the result's order."""
    with reading(database) as session:
        calibration = latest_calibration(session, name)
        draws = load_draws(session, calibration.id)
    return {key: draws[key] for key in calibration.result["parameters"] if key in draws}


def require_unchanged(stored: StoredFit) -> None:
    """Raise `AvahazardError` where the records have changed since the calibration."""
    if stored.records_changed:
        raise AvahazardError(
            f"The records have changed since {stored.name} was calibrated.",
            "Calibrate it again under another name: avahazard calibrate NAME.",
        )
