"""The catalogue of effects, beside what the present data can tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.effects.catalogue import catalogue, definition
from avahazard.effects.covariate import covariate
from avahazard.effects.effect import Definition, Effect, Parameter
from avahazard.effects.own_file import TEMPLATE
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.models import (
    EffectDetails,
    EffectEntry,
    EffectParameter,
    WrittenTemplate,
)
from avahazard.store.records import load_records
from avahazard.store.session import reading

NO_DATA = "there are no events yet"


def list_effects(database: str) -> Rows[EffectEntry]:
    """Return an entry for every effect, and for every column."""
    observations = _study(database)
    entries = list(catalogue().values())
    if observations is not None:
        names = (*observations.columns.numbers, *observations.columns.texts)
        entries += [covariate(name) for name in names]
    return Rows(_entry(entry, observations) for entry in entries)


def show_effect(database: str, key: str) -> EffectDetails:
    """Return the entry of one effect, what it acts on, and its parameters.

    Where an effect is made from the data (levels, ranges) and these are lacking, `acts_on` is
    None and `parameters` empty.

    Raises:
        AvahazardError: there is no such effect.
    """
    entry = definition(key)
    observations = _study(database)
    result = _entry(entry, observations)
    effect = None
    if observations is not None and result.lacking is None:
        effect = entry.build(entry.facts(observations.columns, observations.sites))
    else:
        try:
            effect = entry.build({})
        except KeyError:
            effect = None
    return EffectDetails(
        **result.to_dict(),
        acts_on=_acts_on(entry, effect),
        parameters=Rows(() if effect is None else map(_parameter, effect.parameters)),
    )


def write_template(file: Path) -> WrittenTemplate:
    """Write a commented effect file to start from. Raises `AvahazardError` where it exists."""
    try:
        stream = file.open("x", encoding="utf-8")
    except FileExistsError as error:
        raise AvahazardError(
            f"{file} is there already and is not overwritten.", "Name another file."
        ) from error
    try:
        with stream:
            stream.write(TEMPLATE)
    except BaseException:
        file.unlink(missing_ok=True)
        raise
    return WrittenTemplate(str(file))


def _study(database: str) -> Observations | None:
    """The observations of the present records; None where there is no database or nothing in it."""
    try:
        with reading(database) as session:
            records = load_records(session)
        return build_observations(records)
    except AvahazardError:
        # The catalogue is there before any data are.
        return None


def _entry(entry: Definition, observations: Observations | None) -> EffectEntry:
    lacking = (
        NO_DATA if observations is None else entry.lacking(observations.columns, observations.sites)
    )
    return EffectEntry(entry.key, entry.meaning, entry.needs, lacking)


def _acts_on(entry: Definition, effect: Effect | None) -> str | None:
    if entry.changes is not None:
        return entry.changes.acts_on
    return None if effect is None else effect.acts_on


def _parameter(p: Parameter) -> EffectParameter:
    return EffectParameter(
        name=p.name,
        unit=p.unit,
        neutral=p.neutral,
        prior_mean=p.prior_mean,
        prior_sd=p.prior_sd,
        low=p.low if np.isfinite(p.low) else None,
        high=p.high if np.isfinite(p.high) else None,
    )
