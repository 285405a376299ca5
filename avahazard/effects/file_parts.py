"""What a file of a user's effect declares, taken from it or refused with what would be right."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from avahazard.effects.effect import Parameter
from avahazard.effects.file_forms import FORMS, Form
from avahazard.records.errors import AvahazardError

N_GRID = 9
"""Points of a grid that the file leaves open."""


def text_of(module: dict[str, Any], what: str, name: str) -> str:
    """The text that the file `name` gives as `what`."""
    value = module.get(what)
    if not isinstance(value, str) or not value.strip():
        raise AvahazardError(
            f"{name}: {what} is missing or no text.",
            f'Write a line such as {what} = "{"aspect" if what == "KEY" else "What it does."}".',
        )
    return value.strip()


def needs_of(module: dict[str, Any], name: str) -> tuple[str, ...]:
    """The columns that it needs."""
    value = module.get("NEEDS")
    if not isinstance(value, list | tuple) or not all(isinstance(v, str) for v in value):
        raise AvahazardError(
            f"{name}: NEEDS is missing or no list of texts.",
            'Write NEEDS = ["snow_type"], the columns that it uses; NEEDS = [] for none.',
        )
    return tuple(value)


def function_of(module: dict[str, Any], name: str) -> tuple[Form, Callable[..., Any]]:
    """Its one function, and which form of effect that makes."""
    found = [form for form in FORMS if callable(module.get(form.name))]
    if len(found) != 1:
        have = f"has {' and '.join(f.name for f in found)}" if found else "has none of them"
        raise AvahazardError(
            f"{name}: exactly one function says what the effect acts on; the file {have}.",
            f"They are: {', '.join(f.name for f in FORMS)}.",
        )
    return found[0], module[found[0].name]


def parameters_of(module: dict[str, Any], form: Form, name: str) -> tuple[Parameter, ...]:
    """Its parameters, with grids where the form is tabulated over them."""
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


def check_arguments(
    form: Form, function: Callable[..., Any], parameters: Sequence[Parameter], name: str
) -> None:
    """Raise `AvahazardError` where the function does not take what its form is given."""
    wanted = [form.argument, *(p.name for p in parameters if form.tabulated)]
    if list(inspect.signature(function).parameters) != wanted:
        raise AvahazardError(
            f"{name}: the function {form.name} does not take the right arguments.",
            f"Begin it with: def {form.name}({', '.join(wanted)}):",
        )
