"""The prior that other records give a law: a stored model, or least squares on other paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.effects.effect import Effect, MotionEffect, of_kind
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.laws import law
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.priors import GIVEN, LawPrior, law_prior, prior_of_fit
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.least_squares import fit_law, usable
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.stored.model import load_stored, require_unchanged

FIT = "fit:"
SHOWN = 4
"""Event names that a message lists."""


@dataclass(frozen=True, slots=True)
class PriorFrom:
    """The prior, and the events that speak through it."""

    prior: LawPrior
    events: frozenset[str]


def find_prior(
    database: str,
    source: str,
    specification: Specification,
    effects: Sequence[Effect],
    records: Records,
) -> LawPrior:
    """The prior that `source` gives the law of a model of `specification` on `records`.

    `source` is a stored model, or `fit:PATH[,PATH]…`: least squares on the apparent friction of the
    events of these paths. Paths differ by a source that knows it: where the model does not know it,
    its one path may be any, and the spread between paths is added to the prior of the level.

    Raises:
        AvahazardError: there is no such model or path, records are in both, or friction means
            something else in it (another law, distribution, or effects on the motion).
    """
    found = (
        _of_fit(database, source, specification, effects)
        if source.startswith(FIT)
        else _of_model(database, source, specification, effects)
    )
    _refuse_the_same(found, source, records)
    return found.prior


def _refuse_the_same(found: PriorFrom, source: str, records: Records) -> None:
    both = [e.event_id for e in records.events if e.event_id in found.events]
    if both:
        more = f" and {len(both) - SHOWN} more" if len(both) > SHOWN else ""
        raise AvahazardError(
            f"{len(both)} of {len(records.events)} events already speak through {source} "
            f"({', '.join(both[:SHOWN])}{more}): they would count twice.",
            "Calibrate on other paths (--path PATH), or take a source without these events.",
        )


def _of_model(
    database: str, name: str, specification: Specification, effects: Sequence[Effect]
) -> PriorFrom:
    stored, records = load_stored(database, name)
    require_unchanged(stored)
    theirs = stored.specification
    asked = {
        "law": (theirs.law, specification.law),
        "distribution": (theirs.distribution, specification.distribution),
        "curvature": (theirs.centrifugal, specification.centrifugal),
        "set of effects on the motion": (
            _on_the_motion(stored.effects),
            _on_the_motion(effects),
        ),
    }
    for what, (one, other) in asked.items():
        if one != other:
            raise AvahazardError(
                f"{name} has another {what} ({_told(one)}) than this model ({_told(other)}): its "
                "friction is another one.",
                "Give both models the same.",
            )
    mean, covariance = _moments(stored, {e.key for e in effects})
    prior = law_prior(name, law(specification.law), mean, covariance)
    return PriorFrom(prior, frozenset(_events_behind(database, stored, records)))


def _moments(model: FittedModel, keys: set[str]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of the law's coordinates, the spread between paths in the level."""
    layout = model.layout
    u = model.draws[:, : len(layout.law.coordinates)]
    covariance = np.atleast_2d(np.cov(u, rowvar=False))
    for k, (key, lasts) in enumerate(zip(layout.spreads, model.friction.lasting, strict=True)):
        if lasts and key not in keys:
            # The first coordinate of every law is the log of a level of friction.
            covariance[0, 0] += float(np.mean(layout.spread_values(model.draws)[:, k] ** 2))
    return u.mean(axis=0), covariance


def _events_behind(database: str, stored: FittedModel, records: Records) -> set[str]:
    """The events of a model's calibration, and those behind its own prior."""
    events = set(stored.columns.event_id)
    prior = stored.specification.prior
    if prior is None:
        return events
    if prior.source.startswith(GIVEN):
        return events
    if prior.source.startswith(FIT):
        return events | {e.event_id for e in _paths_of(records, prior.source).events}
    return events | _events_behind(database, *load_stored(database, prior.source))


def _of_fit(
    database: str, source: str, specification: Specification, effects: Sequence[Effect]
) -> PriorFrom:
    if _on_the_motion(effects):
        raise AvahazardError(
            f"A fit knows no {_told(_on_the_motion(effects))}: its friction is not that of this "
            "model.",
            "Take a model with the same effects: --prior-from MODEL.",
        )
    with reading(database) as session:
        records = _paths_of(load_records(session), source)
    observations = build_observations(records)
    curvature = float(specification.centrifugal)
    mu = back_calculate(observations, predict_records(observations, (), {}, curvature)).mu
    volume, mu = usable(np.exp(observations.columns.log_volume), mu)
    fit = fit_law(law(specification.law), volume, mu)
    prior = prior_of_fit(source, fit.law, fit.parameters, fit.covariance, len(mu))
    return PriorFrom(prior, frozenset(event.event_id for event in records.events))


def _paths_of(records: Records, source: str) -> Records:
    names = tuple(name.strip() for name in source.removeprefix(FIT).split(",") if name.strip())
    if not names:
        raise AvahazardError(
            "The prior names no path.", "Name those to fit: --prior-from fit:PATH,PATH"
        )
    return only_paths(records, names)


def _on_the_motion(effects: Sequence[Effect]) -> tuple[str, ...]:
    return tuple(sorted(effect.key for effect in of_kind(effects, MotionEffect)))


def _told(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(value) or "none"
    if isinstance(value, bool):
        return "with" if value else "without"
    return str(value)
