"""Fitted models in and out of the database: the one record of a fit."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

import avahazard
from avahazard.arrays import Floats
from avahazard.effects.columns import NO_EVENTS, build_columns
from avahazard.effects.effect import Definition
from avahazard.inference.fitting.star import REACH
from avahazard.inference.likelihood.assemble import build_effects, definitions_of, find_definition
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_model import friction_model
from avahazard.inference.model.layout import TRACK_SLOT, Layout, arm_between, with_arms
from avahazard.inference.model.observations import (
    build_observations,
    require_one_scale,
    require_profiles,
)
from avahazard.inference.model.priors import GivenPrior, prior_from_document
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel, in_slots
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths, unknown_path
from avahazard.records.plain import plain
from avahazard.results.calibration import Calibration
from avahazard.results.models import Surroundings
from avahazard.store.models import StoredModel, load_model, save_model
from avahazard.store.records import load_records, load_without_profiles
from avahazard.store.results import latest_calibration, load_draws, save_calibration
from avahazard.store.session import Session, reading
from avahazard.workflow.stored.by_path import Survey, any_events, fingerprint_of, survey

COORDINATE, OFFSET = "coordinate:", "offset:"
"""How the draws of coordinates and path offsets are told from readable ones in the store."""
POINTS_ON_DRAWS = 8
"""Points of an arm about the draws of a model that was stored without any."""
PACKAGES = ("numpy", "scipy", "numba", "plotly")
LOCK = Path(avahazard.__file__).parents[1] / "requirements.lock"


def surroundings() -> Surroundings:
    """Versions and lock file of the running program."""
    versions = {"avahazard": avahazard.__version__} | {name: version(name) for name in PACKAGES}
    lock = hashlib.sha256(LOCK.read_bytes()).hexdigest() if LOCK.is_file() else None
    return Surroundings(versions, lock)


def save_calibrated(
    session: Session,
    model: FittedModel,
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
    name, document = result.model, plain(result, keyed=True)
    chains = model.chains
    by_chain = chains.draws.shape[:2]
    slots = [slot.name for slot in model.layout.slots]
    draws = {key: chains.draws[..., k] for k, key in enumerate(chains.names)}
    draws |= {f"{COORDINATE}{s}": model.draws[:, k].reshape(by_chain) for k, s in enumerate(slots)}
    draws |= {f"{OFFSET}{path}": v.reshape(by_chain) for path, v in model.offsets.items()}
    specification = {
        "specification": asdict(model.specification),
        "facts": model.facts,
        "method": model.method,
        "paths": paths,
        "arms": model.layout.arms,
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


def load_stored(
    database: str, name: str, own: Sequence[Definition] = ()
) -> tuple[FittedModel, Records]:
    """The model `name` on the records of its calibration, and all records of the database.

    All of one moment. `own` are the effects of the user's file, which is never run from the
    database. Raises `AvahazardError` where there is no such model, its own effects are not given,
    or there is nothing left of the records that it was calibrated on.
    """
    with reading(database) as session:
        model = _load(session, name, own)
        records = load_records(session)
    training = only_paths(records, model.paths)
    observations = build_observations(training)
    posterior = Posterior(observations, model.specification, model.effects, model.layout.arms)
    slots = [slot.name for slot in model.layout.slots]
    fitted = replace(
        model,
        friction=posterior.friction,
        columns=observations.columns,
        draws=in_slots(posterior.layout, slots, model.draws),
        likelihood=posterior,
        records_changed=data_fingerprint(training) != model.calibration.data_fingerprint,
    )
    # The paper's methods take volumes as exact.
    return fitted if model.knows_errors else fitted.on(observations), records


def load_for_paths(
    database: str, name: str, own: Sequence[Definition] = ()
) -> tuple[FittedModel, Survey]:
    """The model `name` for work path by path, without the records of the region in memory.

    It has the columns of its events, and no likelihood. Raises as `load_stored`.
    """
    with reading(database) as session:
        model = _load(session, name, own)
        found = survey(session)
        for path_id in model.paths:
            if path_id not in found.digests:
                raise unknown_path(path_id, list(found.digests))
        training = only_paths(load_without_profiles(session, model.paths), model.paths)
        today = fingerprint_of(session, model.paths) if model.paths else found.fingerprint
        if model.takes_event_columns:
            found = replace(found, others=any_events(session))
    require_one_scale(training.events)
    used = dict.fromkeys(e.path_id for e in training.events if e.path_id is not None)
    require_profiles(path_id for path_id in used if path_id not in found.with_profile)
    paths = {path.path_id: path for path in training.paths}
    columns = build_columns(training.events, paths, np.full(len(training.events), np.nan))
    changed = today != model.calibration.data_fingerprint
    return replace(model, columns=columns, records_changed=changed), found


def on_events(model: FittedModel, records: Records, events: Sequence[Event]) -> FittedModel:
    """A loaded model on other events of the database's paths.

    Their volumes are read in the light of those that it was calibrated on.
    """
    there = Records(records.paths, records.profiles, tuple(events))
    return model.on(build_observations(there, model.observations))


def load_parameter_draws(database: str, name: str) -> dict[str, Floats]:
    """Draws `[n_chains, n_draws]` of the parameters that people read, in the result's order."""
    with reading(database) as session:
        calibration = latest_calibration(session, name)
        draws = load_draws(session, calibration.id)
    return {key: draws[key] for key in calibration.result["parameters"] if key in draws}


def require_unchanged(model: FittedModel) -> None:
    """Raise `AvahazardError` where the records have changed since the calibration."""
    if model.records_changed:
        raise AvahazardError(
            f"The records have changed since {model.name} was calibrated.",
            "Calibrate it again under another name: avahazard calibrate NAME.",
        )


def version_of(settings: Mapping[str, Any]) -> str | None:
    """The version of the program that made a calibration; None where it was not kept."""
    versions: dict[str, str] = (settings.get("made_with") or {}).get("versions", {})
    return versions.get("avahazard")


def _load(session: Session, name: str, own: Sequence[Definition]) -> FittedModel:
    """What is stored of a model, on no events yet."""
    stored = load_model(session, name)
    calibration = latest_calibration(session, name)
    kept = stored.specification
    fields = kept["specification"]
    specification = Specification(
        **{
            **fields,
            "effects": tuple(fields["effects"]),
            "prior": prior_from_document(fields.get("prior")),
            "given": tuple(GivenPrior(**told) for told in fields.get("given", ())),
        }
    )
    _require_own(stored, specification, own)
    effects = build_effects(specification, kept["facts"], own)
    slots = kept["slots"]
    draws = {key: v.ravel() for key, v in load_draws(session, calibration.id).items()}
    u = np.column_stack([draws[f"{COORDINATE}{slot}"] for slot in slots])
    friction = friction_model(specification, effects, kept.get("arms"), speeds=TRACK_SLOT in slots)
    if "arms" not in kept:
        friction = replace(friction, layout=_on_draws(friction.layout, slots, u))
    return FittedModel(
        specification=specification,
        effects=effects,
        friction=friction,
        columns=NO_EVENTS,
        draws=in_slots(friction.layout, slots, u),
        offsets={k.removeprefix(OFFSET): v for k, v in draws.items() if k.startswith(OFFSET)},
        method=kept["method"],
        definitions=definitions_of(specification, own),
        facts=kept["facts"],
        stored=Calibration.from_dict(calibration.result),
        paths=tuple(kept["paths"]),
        version=version_of(calibration.settings),
    )


def _on_draws(layout: Layout, slots: Sequence[str], u: Floats) -> Layout:
    """A star about the draws u `[n_draws, n_slots]` of slots, for a model that was stored without.

    Versions before this interpolated on grids, from one end of a range to the other.
    """
    arms = {}
    for slot in layout.slots:
        drawn = u[:, slots.index(slot.name)]
        if slot.arm and np.ptp(drawn) > 0.0:
            middle, reach = np.median(drawn), REACH * np.std(drawn)
            low = max(slot.low, min(middle - reach, np.min(drawn)))
            high = min(slot.high, max(middle + reach, np.max(drawn)))
            arms[slot.name] = arm_between(float(middle), float(low), float(high), POINTS_ON_DRAWS)
    return with_arms(layout, arms)


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
