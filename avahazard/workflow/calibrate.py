"""Calibration of a model on the stored records, its priors; a model in full, and made again."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.change import before_and_after
from avahazard.criticism.scoring.error_budget import with_explained
from avahazard.effects.catalogue import catalogue, definition, require
from avahazard.effects.effect import Definition, Effect, MotionEffect, of_kind
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.fitting.mode import FIRST_SPREAD
from avahazard.inference.likelihood.assemble import assemble, build_effects, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model import specification as spec
from avahazard.inference.model.choices import DEFAULT_METHOD, METHODS
from avahazard.inference.model.laws import Law, law, usable
from avahazard.inference.model.layout import Layout, build_layout, in_coordinate
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.calibration import check_method
from avahazard.inference.paper.least_squares import fit_law
from avahazard.inference.sampling import N_CHAINS, calibrate_model
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Records, only_paths
from avahazard.records.errors import AvahazardError
from avahazard.request import fields_of
from avahazard.results.base import Report, plain, silent, steps
from avahazard.results.calibration import Calibration, Difference, Provenance, Rerun
from avahazard.store import results as store
from avahazard.store.records import load_records
from avahazard.store.session import reading, require_writable, writing
from avahazard.workflow.compare import comparison
from avahazard.workflow.effects import read_own_of, stored_text
from avahazard.workflow.listing import in_utc
from avahazard.workflow.next_step import latest_comparison, next_step
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored import (
    calibration_result,
    load_parameter_draws,
    load_stored,
    notes_of,
    records_changed,
    require_unchanged,
    save_calibrated,
    surroundings,
)


def calibrate(
    database: str, name: str, request: CalibrateRequest, report: Report = silent
) -> Calibration:
    """Calibrate a model on the records and store it as `name`: all at the end, or nothing.

    Raises `AvahazardError` where the name is taken, a path or effect is unknown, the data or the
    method cannot estimate an effect, or a prior cannot be that of this model and its records.
    """
    method, paths = request.method, request.paths
    left_out = [definition(key) for key in request.without]
    keys = _kept_effects(request.with_, left_out)
    options = ("law", "scatter", "distribution", "tails", "forward")
    asked = spec.Specification(**{key: getattr(request, key) for key in options})
    for entry in left_out:
        if entry.in_base and entry.changes is not None:
            asked = asked.put(entry.changes, entry.changes.without)
    check_method(method, asked)
    require_writable(database)
    with reading(database) as session:
        store.refuse_taken_name(session, name)
        known = load_records(session)
    records = only_paths(known, paths)
    observations = build_observations(records, forward=asked.forward)
    for entry in catalogue().values():
        if not entry.in_base and asked.has(entry):
            require(entry, observations.columns, observations.sites)
    specification, facts = with_effects(observations, asked, keys)
    effects = build_effects(specification, facts)
    if request.prior_from:
        fitted = find_prior(request.prior_from, specification, effects, records, known)
        specification = replace(specification, prior=fitted)
    if request.prior:
        specification = with_given_priors(specification, request.prior, effects, observations)
    check_method(method, specification)
    progress = partial(report, f"Calibrating {name}")
    progress(0.0)
    found = calibrate_model(
        observations,
        specification,
        facts,
        method=method,
        n_chains=request.chains,
        n_draws=METHODS[method].n_draws if request.draws is None else request.draws,
        seed=request.seed,
        progress=progress,
    )
    result = calibration_result(found, name, records, seed=request.seed)
    document = request_document(request)
    with writing(database) as session:
        save_calibrated(session, found, result, paths=tuple(paths), request=document)
    progress(1.0)
    return replace(result, next=next_step(database, name))


def request_document(request: CalibrateRequest) -> dict[str, Any]:
    """What the database keeps of a request: by it a project knows its model again."""
    return {of.name: plain(getattr(request, of.name)) for of in fields_of(CalibrateRequest)}


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


def with_given_priors(
    specification: spec.Specification,
    numbers: Mapping[str, Sequence[float]],
    effects: Sequence[Effect],
    observations: Observations,
) -> spec.Specification:
    """The specification with priors of these means and standard deviations by parameter.

    Parameters are those that `model NAME` lists. Raises `AvahazardError` where the model has no
    such parameter, it cannot have such a prior, or the law has its prior from other records.
    """
    layout = build_layout(specification, tuple(effects), speeds=bool(observations.speeds))
    others = layout.beside_the_law()
    in_log = {*layout.logs, *layout.spreads.values()}
    positive = set(spec.positive_parameters(layout.law))
    positive |= {name for name, k in others.items() if k in in_log}
    known = (*spec.free_parameters(layout.law), *others)
    given: tuple[spec.GivenPrior, ...] = ()
    for name, pair in numbers.items():
        if len(pair) != 2:
            raise AvahazardError(
                f"The prior of {name} has {len(pair)} of two numbers.",
                "It is two: a mean and a standard deviation.",
            )
        if name not in known:
            raise AvahazardError(
                f"There is no prior of '{name}' in this model ({specification.law} law).",
                f"It may be of {', '.join(sorted(known))}.",
            )
        stated = spec.GivenPrior(name, *map(float, pair))
        given += (stated,)
        spec.require_possible(stated, name in positive)
        if name in others:
            k = others[name]
            _require_in_range(stated, layout, k)
            spec.require_width(name, in_coordinate(layout, k, stated)[1], layout.slots[k].sd)
    prior = spec.given_law_prior(layout.law, given)
    if prior is not None and specification.prior is not None:
        raise AvahazardError(
            f"The law has its prior from {specification.prior.source}: it cannot have another one "
            f"of {prior.source.partition(':')[2]}.",
            "Give --prior-from, or --prior for the parameters of the law.",
        )
    if prior is not None:
        _require_friction(prior, law(specification.law), observations, given)
    return replace(specification, prior=prior or specification.prior, given=given)


def _require_in_range(stated: spec.GivenPrior, layout: Layout, k: int) -> None:
    slot = layout.slots[k]
    low, high = slot.low * slot.scale, slot.high * slot.scale
    if k in layout.logs:
        low, high = float(np.exp(slot.low)), float(np.exp(slot.high))
    if not low <= stated.mean <= high:
        raise AvahazardError(
            f"The prior {stated.name}={stated.mean:g},{stated.sd:g} is out of range.",
            f"The mean of {stated.name} may be {low:g} to {high:g}.",
        )


def _require_friction(
    prior: spec.LawPrior, of: Law, observations: Observations, given: Sequence[spec.GivenPrior]
) -> None:
    """Refuse what gives the middle volume no friction that a block can have: a slip of units."""
    volume = float(np.exp(np.median(observations.volumes.mean))) if of.uses_volume else 1.0
    mu = float(np.exp(of.log_friction(np.array(prior.mean), np.array([volume]))[0]))
    if not MU[0] <= mu <= MU[-1]:
        units = dict(zip(of.names, of.units, strict=True))
        told = (f"{g.name}={g.mean:g} {units[g.name]}".rstrip() for g in given if g.name in units)
        at = f" at the middle volume of {volume:.3g} m3" if of.uses_volume else ""
        usual = "; n of the exponential law is some 1e-6 1/m3" if "n" in units else ""
        raise AvahazardError(
            f"The prior ({', '.join(told)}) gives friction {mu:.2g}{at}.",
            f"Friction is {MU[0]:g} to {MU[-1]:g}{usual}.",
        )


FIT = "fit:"
SHOWN = 4
"""Event names that a message lists."""


def find_prior(
    source: str,
    specification: spec.Specification,
    effects: Sequence[Effect],
    records: Records,
    known: Records,
) -> spec.LawPrior:
    """The prior that `source`, of all `known` records, gives the law of a model on `records`.

    `source` is `fit:PATH[,PATH]…`: least squares on the apparent friction of the events of these
    paths. Raises `AvahazardError` where there is no such path, an event is in both, or the model
    has effects on the motion, with which friction means something else.
    """
    names = tuple(filter(None, map(str.strip, source.removeprefix(FIT).split(","))))
    if not names or not source.startswith(FIT):
        raise AvahazardError(
            f"The prior from '{source}' names no path.",
            "Name those to fit: --prior-from fit:PATH,PATH",
        )
    if moved := sorted(effect.key for effect in of_kind(effects, MotionEffect)):
        raise AvahazardError(
            f"A fit knows no {', '.join(moved)}: its friction is not that of this model.",
            "Give the prior as numbers: --prior NAME=MEAN,SD.",
        )
    fitted = only_paths(known, names)
    speak = {event.event_id for event in fitted.events}
    if both := [e.event_id for e in records.events if e.event_id in speak]:
        more = f" and {len(both) - SHOWN} more" if len(both) > SHOWN else ""
        raise AvahazardError(
            f"{len(both)} of {len(records.events)} events are in the prior too, {source} "
            f"({', '.join(both[:SHOWN])}{more}): they would count twice.",
            "Calibrate on other paths (--path PATH), or take a source without these events.",
        )
    observations = build_observations(fitted)
    curvature = float(specification.centrifugal)
    mu = back_calculate(observations, predict_records(observations, (), {}, curvature)).mu
    volume, mu = usable(np.exp(observations.columns.log_volume), mu)
    fit = fit_law(law(specification.law), volume, mu)
    return spec.prior_of_fit(source, fit.law, fit.parameters, fit.covariance, len(mu))


def add(
    database: str,
    name: str,
    effects: Sequence[str],
    new_name: str,
    *,
    effect_files: Sequence[Path] = (),
    report: Report = silent,
) -> Calibration:
    """Add `effects` to the model `name`, calibrate from its mode, compare, store as `new_name`.

    Chains, draws and seed are the parent's. `effect_files` hold the user's own effects, of the
    parent and new ones. Raises `AvahazardError` where a name is taken or unknown, an effect cannot
    be added, an effect file is missing or changed, or the records have changed since.
    """
    require_writable(database)
    with reading(database) as session:
        model = store.load_model(session, name)
        store.refuse_taken_name(session, new_name)
        before = latest_comparison(session, name)
    own = read_own_of(model, effect_files)
    definitions = tuple(own.values())
    if unused := [key for key in own if key not in (*effects, *model.effects)]:
        raise AvahazardError(
            f"The effect '{unused[0]}' of the effect file is not asked for.",
            f"Name it: avahazard add {shlex.join((name, unused[0]))} --as {shlex.quote(new_name)} "
            "--effect-file FILE.",
        )
    parent, records = load_stored(database, name, own=definitions)
    require_unchanged(parent)
    training = only_paths(records, parent.paths)
    observations = build_observations(training, forward=parent.specification.forward)
    before_it, theirs = parent.specification, parent.calibration
    specification, facts = with_effects(observations, before_it, effects, definitions)
    if specification == before_it:
        raise AvahazardError(f"The model {name} has {', '.join(effects)} already.")
    facts = {**parent.facts, **facts}
    fresh = before is None and parent.sigma_m is None
    tell = steps(report, (2.0, 3.0, 3.0 if fresh else 0.0))
    found = calibrate_model(
        observations,
        specification,
        facts,
        n_chains=theirs.chains if parent.knows_errors else N_CHAINS,
        n_draws=theirs.draws if parent.knows_errors else METHODS[DEFAULT_METHOD].n_draws,
        seed=theirs.seed,
        own=definitions,
        start=start_from(parent, assemble(observations, specification, facts, definitions)),
        progress=partial(tell[0], f"Calibrating {new_name}"),
    )
    result = calibration_result(found, new_name, training, seed=theirs.seed, parent=name)
    after = comparison(new_name, found, partial(tell[1], f"Comparing {new_name}"))
    if fresh:
        before = comparison(name, parent, partial(tell[2], f"Comparing {name}"))
    alike = before
    if before is not None and not before.held_out.alike(after.held_out):
        alike = comparison(name, parent, effects=found.posterior.effects)
        error = alike.held_out.runout.crps_m
        after = replace(after, held_out=replace(after.held_out, parent_crps_m=error))
    after = with_explained(after, before, effects)
    # One transaction: a model that stands without its comparison could not be added again.
    with writing(database) as session:
        text = stored_text(own, specification.effects)
        save_calibrated(session, found, result, paths=parent.paths, effect_file=text)
        if fresh and before is not None:
            store.save_result(session, store.COMPARISON, name, plain(before, keyed=True))
        store.save_result(session, store.COMPARISON, new_name, plain(after, keyed=True))
    scores = before_and_after(alike, after)
    return replace(result, comparison=scores, next=next_step(database, new_name))


def start_from(parent: FittedModel, child: Posterior) -> Floats | None:
    """Coordinates to seek the child's mode from: the parent's, its new ones neutral.

    None, to start from the data, where the parent's coordinates mean something else.
    """
    theirs, ours = parent.specification, child.specification
    alike = theirs.law == ours.law and theirs.reference_volume_m3 == ours.reference_volume_m3
    if not (parent.knows_errors and alike):
        return None
    layout, slots = child.layout, [slot.name for slot in parent.layout.slots]
    neutral = {s.name: s.mean if np.isnan(s.neutral) else s.neutral for s in layout.slots}
    neutral |= {layout.slots[k].name: FIRST_SPREAD for k in layout.spreads.values()}
    known = dict(zip(slots, np.median(parent.draws, axis=0), strict=True))
    return np.array([known.get(name, value) for name, value in neutral.items()])


def show_model(database: str, name: str) -> Calibration:
    """A model's calibration, with its time in UTC. Raises `AvahazardError` where there is none."""
    with reading(database) as session:
        model = store.load_model(session, name)
        known = notes_of(model, load_records(session))
    found = Calibration.from_dict(model.result)
    # Those of the calibration and those of today; the former have not converged in figures.
    notes = [n for n in known if n.key != "unconverged" and n not in found.notes]
    return replace(found, notes=(*found.notes, *notes), created=in_utc(model.created))


def show_provenance(database: str, name: str) -> Provenance:
    """What is needed to make a model again. Raises `AvahazardError` where there is none."""
    with reading(database) as session:
        model = store.load_model(session, name)
        records = load_records(session)
    besides = {
        "created": in_utc(model.created),
        "records_changed": records_changed(model, records),
        "effect_sha256": model.effect_sha256,
        "now": surroundings(),
    }
    kept = {"made_with": None, **model.settings, **model.specification, **model.result}
    return Provenance.from_dict(kept | besides)


def rerun(
    database: str, name: str, *, effect_files: Sequence[Path] = (), report: Report = silent
) -> Rerun:
    """Calibrate the model `name` again and hold every draw against the stored ones.

    Raises `AvahazardError` as `load_stored`, and where its records have changed.
    """
    stored, _ = load_stored(database, name, effect_files)
    own = stored.definitions
    require_unchanged(stored)
    kept = load_parameter_draws(database, name)
    observations, told, start = stored.observations, stored.calibration, None
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
        progress=partial(report, f"Calibrating {name} again"),
    )
    again = dict(zip(found.chains.names, np.moveaxis(found.chains.draws, -1, 0), strict=True))
    differences = {
        key: Difference(*map(float, (old.mean(), new.mean(), np.max(np.abs(old - new)))))
        for key, old in kept.items()
        if (new := again.get(key)) is not None and not np.array_equal(old, new)
    }
    notes = ["the versions that the model was made with were not kept."]
    provenance = show_provenance(database, name)
    if provenance.made_with is not None:
        before = provenance.made_with.versions
        notes = [
            f"{package} was {before.get(package, 'not there')}, and is {now} now."
            for package, now in provenance.now.versions.items()
            if before.get(package) != now
        ]
    return Rerun(name, not differences, len(kept), differences, tuple(notes))
