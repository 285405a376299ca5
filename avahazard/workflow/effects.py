"""The catalogue of effects, beside what the present data can tell, and the user's own files.

Own effects are read from the files that are named, and held against what is stored.
"""

import hashlib
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from avahazard.effects.catalogue import catalogue, definition
from avahazard.effects.covariate import covariate
from avahazard.effects.effect import Definition, Facts, Parameter
from avahazard.effects.own_file import TEMPLATE, declared_key, definition_from, read_text
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.errors import AvahazardError
from avahazard.results import calibration as results
from avahazard.results.base import Rows, finite
from avahazard.store.records import load_records
from avahazard.store.results import StoredModel
from avahazard.store.session import reading
from avahazard.whole_file import written_whole

NO_DATA = "there are no events yet"


def list_effects(database: str) -> Rows[results.EffectEntry]:
    """Return an entry for every effect, and for every column."""
    observations = _study(database)
    entries = list(catalogue().values())
    if observations is not None:
        names = (*observations.columns.numbers, *observations.columns.texts)
        entries += [covariate(name) for name in names]
    return Rows(_entry(entry, observations) for entry in entries)


def show_effect(database: str, key: str) -> results.EffectDetails:
    """Return the entry of one effect, what it acts on, and its parameters.

    Where an effect is made from the data (levels, ranges) and these are lacking, `acts_on` is None
    and `parameters` empty. Raises `AvahazardError` where there is no such effect.
    """
    entry = definition(key)
    observations = _study(database)
    result = _entry(entry, observations)
    facts: Facts = {}
    if observations is not None and result.lacking is None:
        facts = entry.facts(observations.columns, observations.sites)
    parameters, acts_on = Rows[results.EffectParameter](), None
    with suppress(KeyError):
        effect = entry.build(facts)
        parameters, acts_on = Rows(map(_parameter, effect.parameters)), effect.acts_on
    if entry.changes is not None:
        acts_on = entry.changes.acts_on
    return results.EffectDetails(**result.to_dict(), acts_on=acts_on, parameters=parameters)


def write_effect_file(file: Path, text: str = TEMPLATE) -> results.WrittenTemplate:
    """Write a new effect file, or one to start from. Raises `AvahazardError` where it exists."""
    if file.exists():
        raise AvahazardError(
            f"{file} is there already and is not overwritten.", "Name another file."
        )
    with written_whole(file) as part:
        part.write_text(text, encoding="utf-8")
    return results.WrittenTemplate(str(file))


def _study(database: str) -> Observations | None:
    """The observations of the present records; None where there is no database or nothing in it."""
    try:
        with reading(database) as session:
            return build_observations(load_records(session))
    except AvahazardError:
        # The catalogue is there before any data are.
        return None


def _entry(entry: Definition, observations: Observations | None) -> results.EffectEntry:
    lacking: str | None = NO_DATA
    if observations is not None:
        lacking = entry.lacking(observations.columns, observations.sites)
    return results.EffectEntry(entry.key, entry.meaning, entry.needs, lacking)


def _parameter(p: Parameter) -> results.EffectParameter:
    prior = p.prior_mean, p.prior_sd
    return results.EffectParameter(p.name, p.unit, p.neutral, *prior, finite(p.low), finite(p.high))


BETWEEN_FILES = "\n# ======== next effect file ========\n"


def stored_text(own: dict[str, Definition], effects: Iterable[str]) -> str | None:
    """The text that is stored with a model of these effects; None where none is the user's."""
    texts = [own[key].text for key in sorted(set(effects) & own.keys())]
    return BETWEEN_FILES.join(texts) if texts else None


def own_effects(model: StoredModel, files: Sequence[Path]) -> tuple[Definition, ...]:
    """The user's effects of a stored model, from the files that are named again.

    Raises `AvahazardError` where a file is missing, is not the model's, or has changed.
    """
    own = read_own_of(model, files)
    if others := [key for key in own if key not in model.effects]:
        raise AvahazardError(
            f"The model {model.name} does not have the effect '{others[0]}' of the effect file.",
            "Leave --effect-file out, or name the model that has it.",
        )
    return tuple(own.values())


def read_own_of(model: StoredModel, files: Sequence[Path]) -> dict[str, Definition]:
    """The effects of these files by key, none of which runs unless it is that of the model.

    Files with effects that the model does not have are new ones, and run. Raises
    `AvahazardError` for a file that is none, or where the model's own are not given as they were.
    """
    known = () if model.effect_file is None else model.effect_file.split(BETWEEN_FILES)
    texts = [read_text(file) for file in files]
    for file, text in zip(files, texts, strict=True):
        if text not in known and declared_key(text) in model.effects:
            found = hashlib.sha256(text.encode()).hexdigest()
            raise AvahazardError(
                f"The effect file {file} is not the one that {model.name} was made with (its "
                f"SHA-256 is {found[:12]}…); it was not run.",
                "Name the old file, or add the changed effect to the parent under a new name.",
            )
    own: dict[str, Definition] = {}
    for file, text in zip(files, texts, strict=True):
        entry = definition_from(text, str(file))
        if entry.key in own:
            raise AvahazardError(
                f"Two effect files have the KEY '{entry.key}'.", "Rename one of them."
            )
        own[entry.key] = entry
    if not set(texts).issuperset(known):
        raise AvahazardError(
            f"The model {model.name} has an effect from a file of its user's.",
            "Name that file again: --effect-file FILE. It is never run from the database.",
        )
    return own
