"""A user's own effect, from a file of plain Python.

The file says KEY, MEANING, NEEDS and PARAMETERS, and has exactly one of the functions named in
`FORMS`. It becomes a definition with the same rights as one of the catalogue.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.effects.catalogue import catalogue
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import number_column
from avahazard.effects.effect import Definition, Effect, Facts
from avahazard.effects.file_forms import build_effect
from avahazard.effects.file_parts import (
    check_arguments,
    function_of,
    needs_of,
    parameters_of,
    text_of,
)
from avahazard.effects.levels import text_column
from avahazard.effects.needs import needs_profile
from avahazard.effects.site import Site
from avahazard.records.errors import AvahazardError

MIN_KNOWN = 5


@dataclass(frozen=True, slots=True)
class EffectFile:
    """A user's effect and the text that it stands in."""

    definition: Definition
    text: str


def read_effect_file(file: Path) -> EffectFile:
    """Run the file that the user names and take the effect from it.

    Raises `AvahazardError` where the file cannot be read or run, or lacks something.
    """
    text = read_text(file)
    return EffectFile(definition_from(text, str(file)), text)


def read_text(file: Path) -> str:
    """The text of an effect file, which is not run. Raises `AvahazardError` without one."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise AvahazardError(
            f"The effect file {file} cannot be read: {error}.",
            "A template: avahazard effect new FILE.",
        ) from error


def declared_key(text: str) -> str | None:
    """The KEY that the text of an effect file gives as a literal; the file is not run."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return None
    for node in tree.body:
        if not isinstance(node, ast.Assign):
            continue
        for target in node.targets:
            names, values = [target], [node.value]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                names, values = target.elts, node.value.elts
            for name, value in zip(names, values, strict=False):
                if isinstance(name, ast.Name) and name.id == "KEY":
                    key = value.value if isinstance(value, ast.Constant) else None
                    return key.strip() if isinstance(key, str) else None
    return None


def definition_from(text: str, name: str) -> Definition:
    """The definition that a file's text makes; `name` is for messages."""
    module: dict[str, Any] = {"__name__": "effect_file", "__file__": name}
    try:
        # The user's own program, and run only where the user names it (SECURITY.md).
        exec(compile(text, name, "exec"), module)  # noqa: S102
    except (Exception, SystemExit) as error:
        line = getattr(error, "lineno", None) or _line_in(error, name)
        at = f", line {line}" if line else ""
        raise AvahazardError(
            f"The effect file {name} does not run{at}: {type(error).__name__}: {error}.",
            "Try it with Python alone; a template: avahazard effect new FILE.",
        ) from error
    key = text_of(module, "KEY", name)
    if key in catalogue() or ":" in key or len(key.split()) != 1:
        raise AvahazardError(
            f"{name}: KEY = {key!r} cannot be the name of an effect of your own.",
            "Take one word that is not in the catalogue, such as wind-packing.",
        )
    needs = needs_of(module, name)
    form, function = function_of(module, name)
    parameters = parameters_of(module, form, name)
    check_arguments(form, function, parameters, name)
    effect = build_effect(key, form, function, parameters, needs)
    return Definition(
        key=key,
        meaning=text_of(module, "MEANING", name),
        needs=", ".join(needs) or "nothing",
        build=partial(_build, effect),
        lacking=partial(_lacking, needs),
        # Which columns a user's function reads, and what it does to speed, is not known: it may.
        event_columns=True,
        uses_volume=True,
        limits_speed=True,
    )


def _build(effect: Effect, _facts: Facts) -> Effect:
    return effect


def _line_in(error: BaseException, name: str) -> int | None:
    """The line of the file at which it went wrong."""
    line, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == name:
            line = trace.tb_lineno
        trace = trace.tb_next
    return line


def _lacking(needs: tuple[str, ...], columns: EventColumns, sites: Sequence[Site]) -> str | None:
    """What the data lack of the columns that a file needs."""
    for need in needs:
        if need == "profile":
            lack = needs_profile(columns, sites)
        elif need == "land_cover":
            known = any(site.land_cover is not None for site in sites)
            lack = None if known else "no profile has a land_cover"
        else:
            n = known_values(columns, need)
            lack = None if n >= MIN_KNOWN else f"{n} events have a value of {need}"
        if lack is not None:
            return lack
    return None


def known_values(columns: EventColumns, name: str) -> int:
    """Number of events with a value in a column."""
    if name == "date":
        return int(np.sum(np.isfinite(columns.year)))
    numbers = number_column(columns, name)
    if numbers is not None:
        return int(np.sum(np.isfinite(numbers)))
    texts = text_column(columns, name)
    return 0 if texts is None else int(np.sum(texts != ""))
