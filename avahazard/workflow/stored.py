"""What is stored of a model: saving and loading it, what its calibration found, its notes."""

import hashlib
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields, replace
from importlib import import_module
from importlib.metadata import version
from pathlib import Path as FilePath
from typing import Any

import numpy as np

import avahazard
from avahazard.arrays import Floats
from avahazard.criticism.diagnosis import nuisances
from avahazard.criticism.diagnosis.full_fits import kinds_of
from avahazard.effects.columns import NO_EVENTS, EventColumns, build_columns
from avahazard.effects.effect import Definition, known
from avahazard.effects.site import Site
from avahazard.inference.fitted_model import FittedModel, in_slots
from avahazard.inference.likelihood.assemble import build_effects, definitions_of
from avahazard.inference.model import specification as spec
from avahazard.inference.model.choices import BLOCK
from avahazard.inference.model.friction_model import friction_model
from avahazard.inference.model.laws import LAWS
from avahazard.inference.model.layout import TRACK_SLOT, Arms
from avahazard.inference.model.observations import (
    build_observations,
    require_one_scale,
    require_profiles,
)
from avahazard.inference.prediction import drawn_frictions
from avahazard.notes import Note
from avahazard.records import crosscheck
from avahazard.records.collection import (
    Event,
    Profile,
    Records,
    data_fingerprint,
    only_paths,
    unknown_path,
)
from avahazard.records.errors import AvahazardError
from avahazard.results import calibration as results
from avahazard.results.base import plain, reader_of
from avahazard.results.calibration import Surroundings
from avahazard.store import results as store
from avahazard.store.records import load_records
from avahazard.store.session import Session, reading
from avahazard.workflow.by_path import Survey, any_events, fingerprint_of, survey
from avahazard.workflow.effects import own_effects

COORDINATE, OFFSET = "coordinate:", "offset:"
"""Prefixes of the draws of coordinates and path offsets in the store."""
PACKAGES = ("numpy", "scipy", "numba", "plotly")
LOCK = FilePath(avahazard.__file__).parents[1] / "requirements.lock"


def surroundings() -> Surroundings:
    """Versions and lock file of the running program."""
    versions = {"avahazard": avahazard.__version__} | {name: version(name) for name in PACKAGES}
    lock = hashlib.sha256(LOCK.read_bytes()).hexdigest() if LOCK.is_file() else None
    return Surroundings(versions, lock)


def save_calibrated(
    session: Session,
    model: FittedModel,
    result: results.Calibration,
    *,
    paths: tuple[str, ...] = (),
    request: dict[str, Any] | None = None,
    effect_file: str | None = None,
) -> None:
    """Store a model with its calibration in the transaction of `session`.

    `paths` are those that it was calibrated on, none: all; `request` is what `calibrate` was asked
    for; `effect_file` is the text of the user's effects. Raises as `store.results.save_model`.
    """
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
        "arms": model.layout.arms.points,
        "along": model.layout.arms.along,
        "beside": model.layout.arms.beside,
        "slots": slots,
    }
    settings = {
        "method": model.method,
        "chains": by_chain[0],
        "draws": by_chain[1],
        "made_with": surroundings().to_dict(),
        "request": request,
    }
    document = plain(result, keyed=True)
    store.save_model(session, specification, settings, document, draws, effect_file)


def load_stored(
    database: str,
    name: str,
    effect_files: Sequence[FilePath] = (),
    own: Sequence[Definition] | None = None,
) -> tuple[FittedModel, Records]:
    """The model `name` on the records of its calibration, and all records of the same moment.

    `effect_files` hold the user's effects, which are never run from the database; or these are
    known already (`own`). Raises `AvahazardError` where there is no such model, its own effects are
    not given as they were, or nothing is left of the records that it was calibrated on.
    """
    with reading(database) as session:
        model = _load(session, name, effect_files, own)
        records = load_records(session)
    training = only_paths(records, model.paths)
    observations = build_observations(training, forward=model.specification.forward)
    changed = data_fingerprint(training) != model.calibration.data_fingerprint
    return replace(model.on(observations), records_changed=changed), records


def records_of(database: str) -> Records:
    """All records of a database."""
    with reading(database) as session:
        return load_records(session)


def load_for_paths(
    database: str, name: str, effect_files: Sequence[FilePath] = ()
) -> tuple[FittedModel, Survey]:
    """The model `name` for work path by path, without the records of the region in memory.

    It has the columns of its events, and no likelihood. Raises as `load_stored`.
    """
    with reading(database) as session:
        model = _load(session, name, effect_files)
        if model.specification.forward != BLOCK:
            raise AvahazardError(
                f"{name} is a model of {model.specification.forward}: it has no block that runs "
                "along the paths.",
                f"Draw its map: avahazard map {shlex.quote(name)} -o FILE.tif.",
            )
        found = survey(session)
        for path_id in model.paths:
            if path_id not in found.digests:
                raise unknown_path(path_id, list(found.digests))
        training = only_paths(
            load_records(session, model.paths or None, profiles=False, speeds=False), model.paths
        )
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


def on_events(
    model: FittedModel, records: Records, events: Sequence[Event], among: EventColumns | None = None
) -> FittedModel:
    """A model on other events, whose volumes are read in the light of those of its calibration.

    They are counted `among` others, by default those of its calibration.
    """
    there = Records(records.paths, records.profiles, tuple(events))
    return model.on(build_observations(there, model.observations, among=among))


def limits_speed(model: FittedModel) -> bool:
    """Whether an effect of the model holds the speed on steep and long paths."""
    return any(entry.limits_speed for entry in model.definitions)


def load_parameter_draws(database: str, name: str) -> dict[str, Floats]:
    """Draws `[n_chains, n_draws]` of the parameters that people read, in the result's order."""
    with reading(database) as session:
        model = store.load_model(session, name)
        draws = store.load_draws(session, model.calibration)
    return {key: draws[key] for key in model.result["parameters"] if key in draws}


def require_friction_scatter(model: FittedModel) -> None:
    """Raise `AvahazardError` where the scatter of a model is in metres of the stop."""
    if model.sigma_m is not None:
        raise AvahazardError(
            f"The scatter of {model.name} is in metres of the stop (method {model.method}): it "
            "holds all errors at once, and says nothing of friction.",
            "Calibrate with --method marginal (or gibbs).",
        )


def require_unchanged(model: FittedModel) -> None:
    """Raise `AvahazardError` where the records have changed since the calibration."""
    if model.records_changed:
        raise AvahazardError(
            f"The records have changed since {model.name} was calibrated.",
            "Calibrate it again under another name: avahazard calibrate NAME.",
        )


def _load(
    session: Session,
    name: str,
    effect_files: Sequence[FilePath],
    own: Sequence[Definition] | None = None,
) -> FittedModel:
    """What is stored of a model, on no events yet."""
    stored = store.load_model(session, name)
    own = own_effects(stored, effect_files) if own is None else own
    kept = stored.specification
    specification = reader_of(spec.Specification)(kept["specification"])
    effects = build_effects(specification, kept["facts"], own)
    slots = kept["slots"]
    draws = {key: v.ravel() for key, v in store.load_draws(session, stored.calibration).items()}
    u = np.column_stack([draws[f"{COORDINATE}{slot}"] for slot in slots])
    arms = Arms(kept["arms"], kept.get("along", {}), kept.get("beside", {}))
    friction = friction_model(specification, effects, arms, speeds=TRACK_SLOT in slots)
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
        stored=results.Calibration.from_dict(stored.result),
        paths=stored.paths,
        version=stored.version,
    )


SPECIFIED = {f.name for f in fields(spec.Specification)} & {
    f.name for f in fields(results.Calibration)
}
"""What a result repeats of the specification."""
STILL_PRIOR = 0.75
"""Posterior over prior standard deviation where the records tell less than the prior (with
independent normals they tell as much at 0.71)."""


def calibration_result(
    found: FittedModel, name: str, records: Records, *, seed: int, parent: str | None = None
) -> results.Calibration:
    """Sum up what was found of a model on `records`: its parameters, convergence, with notes."""
    specification, chains, observations = found.specification, found.chains, found.observations
    checks = chains.diagnostics
    notes: list[Note] = []
    differ, gain = nuisances.paths_differ(found, name), nuisances.heavier_tails(found)
    if differ is not None and differ.values["nats"] >= nuisances.WORTH_A_NOTE:
        notes.append(differ)
    if gain is not None and gain > nuisances.HEAVY_TAILS:
        notes.append(Note("heavier_tails", model=name, nats=gain))
    notes += found.notes
    if not checks.converged:
        notes.append(Note("not_converged", rhat=checks.rhat_max, ess=checks.ess_min))
    notes += prior_notes(found, name)
    recorded = known(found.columns.log_volume)
    common = float(np.exp(np.median(recorded))) if len(recorded) else SOME_VOLUME_M3
    mu = float(np.median(drawn_frictions(found, None, common)))
    if mu > HIGH_FRICTION:
        notes.append(Note("friction_high", model=name, mu=mu))
    notes += (*record_notes(records, observations.sites), *volume_notes(found, name))
    notes += (Note("outcome_column", column=k, rank=r) for k, r in observations.outcomes.items())
    return results.Calibration(
        model=name,
        parent=parent,
        method=found.method,
        **{key: getattr(specification, key) for key in SPECIFIED},
        n_events=found.n_events,
        left_out=dict(found.left_out),
        parameters={key: summary(draws, unit) for key, draws, unit in _all_draws(found)},
        diagnostics=checks,
        chains=chains.draws.shape[0],
        draws=chains.draws.shape[1],
        seed=seed,
        data_fingerprint=data_fingerprint(records),
        notes=tuple(notes),
        kinds=kinds_of(found),
    )


def prior_notes(model: FittedModel, name: str) -> Iterator[Note]:
    """Where priors are not the program's own, and the coordinates that records hardly narrow."""
    from scipy.stats import truncnorm  # noqa: PLC0415 (slow)

    specification, layout = model.specification, model.layout
    for given in specification.given:
        yield Note("prior_given", parameter=given.name, model=name, mean=given.mean, sd=given.sd)
    law_prior = specification.prior
    if law_prior is not None and not law_prior.source.startswith(spec.GIVEN):
        yield Note("prior_from", model=name, source=law_prior.source)
    # The paper's methods have a σ of their own.
    n_slots = len(layout.slots) if model.knows_errors else len(layout.law.coordinates)
    curves = [
        (entry.key, entry.curve(model.facts.get(entry.key, {}))) for entry in model.definitions
    ]
    places = [layout.places[key] for key, curve in curves if curve is not None and curve.form]
    # Priors keep a smooth smooth: its bends are theirs by design.
    bends = {k for place in places for k in range(place.start + 1, place.stop)}
    for k, slot in enumerate(layout.slots[:n_slots]):
        if k in bends:
            continue
        prior = truncnorm(*slot.bounds, loc=slot.mean, scale=slot.sd)
        mean, sd = float(prior.mean()), float(prior.std())
        draws = np.log(model.draws[:, k]) if slot.lognormal else model.draws[:, k]
        ratio = float(np.std(draws, ddof=1)) / sd
        if ratio > STILL_PRIOR:
            moved = abs(float(np.mean(draws)) - mean) / sd
            told = {"moved": moved, "width": ratio}
            yield Note("prior_dominated", parameter=slot.name, model=name, **told)


def _all_draws(found: FittedModel) -> Iterator[tuple[str, Floats, str]]:
    """Name, draws and unit of every parameter, offsets of paths last."""
    for k, (name, unit) in enumerate(zip(found.chains.names, found.chains.units, strict=True)):
        yield name, found.chains.draws[..., k].ravel(), unit
    plan = found.posterior.plan
    for name, told, g in zip(plan.names, plan.told, plan.of, strict=True):
        # Winters and storms are past: their spread is what matters.
        if plan.persistent[g] and name in found.offsets:
            yield told, found.offsets[name], "log friction"


def summary(draws: Floats, unit: str) -> results.ParameterSummary:
    """Mean, sd, mode and 5 and 95 % quantiles of draws `[n]`."""
    mean, sd = float(draws.mean()), float(draws.std(ddof=1))
    low, high = np.quantile(draws, [0.05, 0.95]).tolist()
    return results.ParameterSummary(mean, sd, mode(draws), low, high, unit)


def mode(draws: Floats) -> float:
    """The draw of `[n]` at which their density is highest, by ArviZ's kernels."""
    array_stats = import_module("arviz_stats.base").array_stats  # slow to import, so only here
    middle, width = float(np.median(draws)), float(np.ptp(draws))
    if not 0.0 < width < np.inf:
        return middle
    # Whose squares neither vanish nor overflow.
    z = (draws - middle) / width
    places, density, _ = array_stats.kde(z)
    return float(draws[np.argmin(np.abs(z - places[np.argmax(density)]))])


OF_THE_RUN = ("events_left_out", "no_speeds", "not_converged")
"""Notes of a calibration that do not go with what is computed by its model."""
FEW_EVENTS = 10
SOME_VOLUME_M3, HIGH_FRICTION = 1e4, 1.0
"""Where no record has a volume; median friction above which units are rather wrong."""
"""Events under which a model is one of its priors, whatever the chains say."""
MISFIT_M = 10.0
"""Deviation of the regularised path from its points that is worth a note."""
MISFIT_SIGMAS = 4.0
"""… where it is also that many times their error: the farthest of hundreds lies some 3 away."""


def notes_of_fit(model: FittedModel) -> tuple[Note, ...]:
    """The notes on a model that is loaded."""
    return model_notes(model.calibration, model.records_changed, model.version)


def notes_of(model: store.StoredModel, records: Records) -> tuple[Note, ...]:
    """The notes on a stored model, without loading its draws; `records` are those of today."""
    found = results.Calibration.from_dict(model.result)
    return model_notes(found, records_changed(model, records), model.version)


def records_changed(model: store.StoredModel, records: Records) -> bool:
    """Whether the records have changed since a model was calibrated; `records` are today's."""
    today = data_fingerprint(only_paths(records, model.paths))
    return bool(today != model.result["data_fingerprint"])


def model_notes(
    result: results.Calibration, records_changed: bool, version: str | None
) -> tuple[Note, ...]:
    """The notes on what a calibration found; `version` is that of the program that made it."""
    name, n, now = result.model, result.n_events, avahazard.__version__
    notes = [note for note in result.notes if note.key not in OF_THE_RUN]
    if records_changed:
        notes.append(Note("stale", model=name))
    if not result.diagnostics.converged:
        notes.append(Note("unconverged", model=name))
    if n < FEW_EVENTS:
        notes.append(Note("few_events", model=name, n=n))
    if version is not None and version != now:
        notes.append(Note("older_version", model=name, version=version, now=now))
    return tuple(notes)


def volume_notes(model: FittedModel, name: str) -> tuple[Note, ...]:
    """That its volumes have a largest one, where friction goes by volumes with errors."""
    volumes = model.observations.volumes
    if not LAWS[model.specification.law].uses_volume or not np.any(volumes.sd > 0.0):
        return ()
    if np.isinf(volumes.largest):
        return ()
    return (Note("largest_volume", model=name, largest=float(f"{volumes.largest:.2g}")),)


def record_notes(records: Records, sites: Sequence[Site]) -> tuple[Note, ...]:
    """Paths that miss their terrain, events that cannot be true, or stand twice, undetected stops.

    An import refuses the second; a database of an earlier version may hold them.
    """
    profiles = {profile.path_id: profile for profile in records.profiles}
    paths = {path.path_id: path for path in records.paths}
    notes = list(_misfits(profiles, sites))
    above: dict[str, list[tuple[float, str]]] = {}
    for event in records.events:
        path, profile = paths.get(event.path_id or ""), profiles.get(event.path_id or "")
        fault = crosscheck.volume_fault(event)
        if fault is None and profile is not None:
            fault = crosscheck.place_fault(event, path, profile)
        if fault is not None:
            values = dict(zip(("column", "value", "accepted"), fault, strict=True))
            notes.append(Note("contradicts_itself", event.event_id, **values))
        if path is None:
            continue
        if (elevation := crosscheck.unseen_elevation(event, path, profile)) is not None:
            above.setdefault(path.path_id, []).append((elevation, event.event_id))
    for path_id, stops in above.items():
        highest, events = zip(*sorted(stops, reverse=True), strict=True)
        told = {"n": len(stops), "limit": paths[path_id].observed_below_m, "events": list(events)}
        notes.append(Note("above_limit", path_id, **told, elevation=highest[0]))
    return (*notes, *crosscheck.repeated(records.events))


def _misfits(profiles: Mapping[str, Profile], sites: Sequence[Site]) -> Iterator[Note]:
    """Profiles whose points the smoothed path misses."""
    for path_id, site in {site.path.path_id: site for site in sites}.items():
        profile, smooth = profiles.get(path_id), site.smooth
        if profile is None:  # a straight line has no points to miss
            continue
        away = np.abs(smooth.height(profile.x_m) - profile.y_m)
        k = int(np.argmax(away))
        if away[k] > max(MISFIT_M, MISFIT_SIGMAS * smooth.sigma_m):
            yield Note("misses_points", path_id, away=float(away[k]), x=float(profile.x_m[k]))
