"""A user's own effect, from a file of plain Python.

The file says KEY, MEANING, NEEDS and PARAMETERS, and has exactly one of the functions named in
`FORMS`. It becomes a definition with the same rights as one of the catalogue.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.effects.catalogue import catalogue
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import number_column
from avahazard.effects.effect import Definition, Effect, Facts, Parameter
from avahazard.effects.file_forms import FORMS, Form, build_effect
from avahazard.effects.levels import text_column
from avahazard.effects.needs import needs_profile
from avahazard.effects.site import Site
from avahazard.records.errors import AvahazardError

N_GRID = 9
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
    key = _text(module, "KEY", name)
    if key in catalogue() or ":" in key or len(key.split()) != 1:
        raise AvahazardError(
            f"{name}: KEY = {key!r} cannot be the name of an effect of your own.",
            "Take one word that is not in the catalogue, such as wind-packing.",
        )
    needs = _needs(module, name)
    form, function = _function(module, name)
    parameters = _parameters(module, form, name)
    _check_arguments(form, function, parameters, name)
    effect = build_effect(key, form, function, parameters, needs)
    return Definition(
        key=key,
        meaning=_text(module, "MEANING", name),
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


def _text(module: dict[str, Any], what: str, name: str) -> str:
    value = module.get(what)
    if not isinstance(value, str) or not value.strip():
        raise AvahazardError(
            f"{name}: {what} is missing or no text.",
            f'Write a line such as {what} = "{"aspect" if what == "KEY" else "What it does."}".',
        )
    return value.strip()


def _needs(module: dict[str, Any], name: str) -> tuple[str, ...]:
    value = module.get("NEEDS")
    if not isinstance(value, list | tuple) or not all(isinstance(v, str) for v in value):
        raise AvahazardError(
            f"{name}: NEEDS is missing or no list of texts.",
            'Write NEEDS = ["snow_type"], the columns that it uses; NEEDS = [] for none.',
        )
    return tuple(value)


def _function(module: dict[str, Any], name: str) -> tuple[Form, Callable[..., Any]]:
    found = [form for form in FORMS if callable(module.get(form.name))]
    if len(found) != 1:
        have = f"has {' and '.join(f.name for f in found)}" if found else "has none of them"
        raise AvahazardError(
            f"{name}: exactly one function says what the effect acts on; the file {have}.",
            f"They are: {', '.join(f.name for f in FORMS)}.",
        )
    return found[0], module[found[0].name]


def _parameters(module: dict[str, Any], form: Form, name: str) -> tuple[Parameter, ...]:
    given = module.get("PARAMETERS")
    if (
        not isinstance(given, list | tuple)
        or not given
        or not all(isinstance(p, Parameter) for p in given)
    ):
        raise AvahazardError(
            f"{name}: PARAMETERS is missing or no list of Parameter(...).",
            'Write PARAMETERS = [Parameter("north", "log friction", neutral=0.0, prior_mean=0.0, '
            "prior_sd=0.2)].",
        )
    return tuple(_checked(p, form, name) for p in given)


def _checked(p: Parameter, form: Form, name: str) -> Parameter:
    """The parameter, with a grid where the effect is tabulated."""
    wrong = ""
    if not p.name.isidentifier():
        wrong = "its name must be one word of letters, digits and _"
    elif not (np.isfinite(p.prior_mean) and np.isfinite(p.neutral) and 0 < p.prior_sd < np.inf):
        wrong = "neutral, prior_mean and prior_sd > 0 must be numbers"
    elif not p.low <= p.neutral <= p.high or not p.low <= p.prior_mean <= p.high:
        wrong = "neutral and prior_mean must lie in [low, high]"
    elif not form.tabulated and p.neutral != 0.0:
        wrong = "friction is multiplied by the parameter, so that neutral must be 0"
    elif form.tabulated and not (np.isfinite(p.low) and np.isfinite(p.high) and p.low < p.high):
        wrong = f"{form.name} is tabulated over it and needs low < high"
    if wrong:
        raise AvahazardError(f"{name}: parameter {p.name!r}: {wrong}.")
    if not form.tabulated:
        return Parameter(p.name, p.unit, 0.0, p.prior_mean, p.prior_sd, p.low, p.high)
    grid = p.grid or tuple(np.linspace(p.low, p.high, N_GRID))
    # The neutral value is a point of the grid, so that the effect can vanish exactly.
    points = tuple(sorted({*(float(g) for g in grid), float(p.neutral)}))
    return Parameter(
        p.name, p.unit, p.neutral, p.prior_mean, p.prior_sd, points[0], points[-1], points
    )


def _check_arguments(
    form: Form, function: Callable[..., Any], parameters: Sequence[Parameter], name: str
) -> None:
    wanted = [form.argument, *(p.name for p in parameters if form.tabulated)]
    if list(inspect.signature(function).parameters) != wanted:
        raise AvahazardError(
            f"{name}: the function {form.name} does not take the right arguments.",
            f"Begin it with: def {form.name}({', '.join(wanted)}):",
        )


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
