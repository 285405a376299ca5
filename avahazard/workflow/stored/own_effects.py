"""The user's own effects: read from the files that are named, and held against what is stored."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from pathlib import Path

from avahazard.effects.effect import Definition
from avahazard.effects.own_file import EffectFile, declared_key, read_effect_file, read_text
from avahazard.records.errors import AvahazardError
from avahazard.store.models import StoredModel, load_model
from avahazard.store.session import reading

BETWEEN_FILES = "\n# ======== next effect file ========\n"


def read_own(files: Sequence[Path]) -> dict[str, EffectFile]:
    """The effects of these files by key. Raises `AvahazardError` for a file that is none."""
    found: dict[str, EffectFile] = {}
    for file in files:
        effect = read_effect_file(file)
        key = effect.definition.key
        if key in found:
            raise AvahazardError(f"Two effect files have the KEY '{key}'.", "Rename one of them.")
        found[key] = effect
    return found


def stored_text(own: dict[str, EffectFile], effects: Iterable[str]) -> str | None:
    """The text that is stored with a model of these effects; None where none is the user's."""
    texts = [own[key].text for key in sorted(set(effects) & own.keys())]
    return BETWEEN_FILES.join(texts) if texts else None


def own_effects(database: str, name: str, files: Sequence[Path]) -> tuple[Definition, ...]:
    """The user's effects of the stored model `name`, from the files that are named again.

    Raises `AvahazardError` where a file is missing, is not the model's, or has changed.
    """
    with reading(database) as session:
        model = load_model(session, name)
    own = read_own_of(model, files)
    for key in own:
        if key not in effects_of(model):
            raise AvahazardError(
                f"The model {name} does not have the effect '{key}' of the effect file.",
                "Leave --effect-file out, or name the model that has it.",
            )
    return tuple(effect.definition for effect in own.values())


def files_of(files: Sequence[Path], effects: Sequence[str]) -> tuple[Path, ...]:
    """Those of the files whose effect is among `effects`; nothing is run."""
    return tuple(file for file in files if declared_key(read_text(file)) in effects)


def read_own_of(model: StoredModel, files: Sequence[Path]) -> dict[str, EffectFile]:
    """The effects of these files by key, none of which runs unless it is that of the model.

    Files with effects that the model does not have are new ones, and run. Raises
    `AvahazardError` as `read_own` and `check_own` do.
    """
    known = () if model.effect_file is None else model.effect_file.split(BETWEEN_FILES)
    for file in files:
        text = read_text(file)
        if text not in known and declared_key(text) in effects_of(model):
            found = hashlib.sha256(text.encode()).hexdigest()
            raise AvahazardError(
                f"The effect file {file} is not the one that {model.name} was made with (its "
                f"SHA-256 is {found[:12]}…); it was not run.",
                "Name the old file, or add the changed effect to the parent under a new name.",
            )
    own = read_own(files)
    check_own(model, own)
    return own


def check_own(model: StoredModel, own: dict[str, EffectFile]) -> None:
    """Raise `AvahazardError` where the model's own effects are not given as they were."""
    if model.effect_sha256 is None:
        return
    text = stored_text(own, effects_of(model))
    if text is None:
        raise AvahazardError(
            f"The model {model.name} has an effect from a file of its user's.",
            "Name that file again: --effect-file FILE. It is never run from the database.",
        )
    found = hashlib.sha256(text.encode()).hexdigest()
    if found != model.effect_sha256:
        raise AvahazardError(
            f"The effect file is not the one that {model.name} was made with: its SHA-256 is "
            f"{found[:12]}…, that of the model's {model.effect_sha256[:12]}….",
            "Name the old file, or add the changed effect to the parent under a new name.",
        )


def effects_of(model: StoredModel) -> tuple[str, ...]:
    """Keys of a stored model's effects."""
    return tuple(model.specification["specification"]["effects"])
