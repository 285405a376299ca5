"""Calibration of a model on the stored records, and its storage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.effects.catalogue import catalogue, definition, require
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import build_effects, with_effects
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import (
    Specification,
)
from avahazard.inference.paper.calibration import check_method
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.results.base import Report, silent
from avahazard.results.calibration import Calibration
from avahazard.store.models import refuse_taken_name
from avahazard.store.records import load_records
from avahazard.store.session import reading, writing
from avahazard.workflow.priors import find_prior, with_given_priors
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored.calibration import calibration_result
from avahazard.workflow.stored.model import save_calibrated


def calibrate(
    database: str,
    name: str,
    request: CalibrateRequest,
    report: Report = silent,
) -> Calibration:
    """Calibrate a model on the records and store it as `name`: all at the end, or nothing.

    Raises:
        AvahazardError: the name is taken, a path or effect is unknown or cannot be told from
            the data, the method cannot do it, or a prior is not that of this model's friction,
            comes from the same events, or cannot be.
    """
    method, paths = request.method, request.paths
    left_out = [definition(key) for key in request.without]
    keys = _kept_effects(request.with_, left_out)
    asked = asked_for(
        Specification(
            law=request.law,
            scatter=request.scatter,
            distribution=request.distribution,
            tails=request.tails,
        ),
        left_out,
    )
    check_method(method, asked)
    with reading(database) as session:
        refuse_taken_name(session, name)
        records = only_paths(load_records(session), paths)
    observations = build_observations(records)
    for entry in catalogue().values():
        if not entry.in_base and asked.has(entry):
            require(entry, observations.columns, observations.sites)
    specification, facts = with_effects(observations, asked, keys)
    effects = build_effects(specification, facts)
    if request.prior_from:
        found_prior = find_prior(database, request.prior_from, specification, effects, records)
        specification = replace(specification, prior=found_prior)
    if request.prior:
        specification = with_given_priors(specification, request.prior, effects, observations)
    check_method(method, specification)
    report(f"Calibrating {name}", 0.0, 1.0)
    found = calibrate_model(
        observations,
        specification,
        facts,
        method=method,
        n_chains=request.chains,
        n_draws=METHODS[method].n_draws if request.draws is None else request.draws,
        seed=request.seed,
        progress=lambda share: report(f"Calibrating {name}", share, 1.0),
    )
    result = calibration_result(found, name, records, seed=request.seed)
    with writing(database) as session:
        save_calibrated(session, found, result, paths=tuple(paths))
    return result


def asked_for(specification: Specification, left_out: Sequence[Definition]) -> Specification:
    """The specification less what the base model has and is asked away."""
    for entry in left_out:
        if entry.in_base and entry.changes is not None:
            specification = specification.put(entry.changes, entry.changes.without)
    return specification


def _kept_effects(with_: Sequence[str], left_out: Sequence[Definition]) -> list[str]:
    """Effects asked for less those asked away; what the base model has may be in any case."""
    for entry in left_out:
        if not entry.in_base and entry.key not in with_:
            base = [e.key for e in catalogue().values() if e.in_base]
            raise AvahazardError(
                f"The model does not have the effect '{entry.key}'.",
                f"Only {', '.join(base)} is in the base model: --without {base[0]}.",
            )
    away = {entry.key for entry in left_out}
    return [key for key in dict.fromkeys(with_) if key not in away]
