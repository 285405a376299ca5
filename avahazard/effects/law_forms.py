"""Forms that the curve of a smooth effect may have, and the effect file of each.

A form gives the curve at states s from its change and, of some, a shape: a place and a width, an
exponent. `low` and `high` are the ends of the states that the curve is known at.
"""

import ast
import inspect
import re
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.effect import Curve, Parameter


def constant(s: Floats, change: float) -> Floats:
    """The same at all states."""
    return change + 0.0 * s


def linear(s: Floats, low: float, high: float, change: float) -> Floats:
    """A line that changes by `change` from `low` to `high`."""
    return change * (s - low) / (high - low)


def power(s: Floats, high: float, change: float, exponent: float) -> Floats:
    """A power of the state, `change` at `high`."""
    return change * (np.maximum(s, 0.0) / high) ** exponent


def above(s: Floats, high: float, change: float, threshold: float, exponent: float) -> Floats:
    """A power of what the state is above a threshold, `change` at `high`."""
    return change * (np.maximum(s - threshold, 0.0) / (high - threshold)) ** exponent


def below(s: Floats, low: float, change: float, limit: float, exponent: float) -> Floats:
    """A power of what the state is below a limit, `change` at `low`."""
    return change * (np.maximum(limit - s, 0.0) / (limit - low)) ** exponent


def exponential(s: Floats, low: float, high: float, change: float, length: float) -> Floats:
    """Exponential growth, 0 at `low` and `change` at `high`."""
    return change * np.expm1((s - low) / length) / float(np.expm1((high - low) / length))


def saturating(s: Floats, low: float, change: float, length: float) -> Floats:
    """A rise from 0 at `low` that levels out at `change`."""
    return -change * np.expm1(-np.maximum(s - low, 0.0) / length)


def step(s: Floats, change: float, centre: float, width: float) -> Floats:
    """A logistic step by `change` about `centre`."""
    return change / (1.0 + np.exp(-(s - centre) / width))


def hump(s: Floats, change: float, centre: float, width: float) -> Floats:
    """A band about `centre`, `change` at its middle."""
    return change * np.exp(-0.5 * ((s - centre) / width) ** 2)


FORMULAS: Mapping[Callable[..., Floats], str] = {
    constant: "change",
    linear: "change (s - low) / (high - low)",
    power: "change (s / high)^exponent",
    above: "change ((s - threshold)+ / (high - threshold))^exponent",
    below: "change ((limit - s)+ / (limit - low))^exponent",
    exponential: "change (e^((s - low)/length) - 1) / (e^((high - low)/length) - 1)",
    saturating: "change (1 - e^(-(s - low)+ / length))",
    step: "change / (1 + e^(-(s - centre)/width))",
    hump: "change e^(-((s - centre)/width)²/2)",
}
"""The forms, and how people write them; ( )+ is 0 where it would be negative."""


@dataclass(frozen=True, slots=True, eq=False)
class LawForm:
    """A form that a curve may have: its change, then its shape; more of one form have a number."""

    function: Callable[..., Floats]
    curve: Curve
    parameters: tuple[Parameter, ...]
    number: int = 1

    @property
    def name(self) -> str:
        """Its name."""
        return self.function.__name__

    @property
    def formula(self) -> str:
        """How people write it."""
        return FORMULAS[self.function]

    @property
    def key(self) -> str:
        """The key of the effect that it makes."""
        of = re.sub(r"[^a-z0-9]+", "-", self.curve.of.lower()).strip("-")
        return f"{of or 'column'}-{self.name}" + (f"-{self.number}" if self.number > 1 else "")

    def shape(self, s: Floats, values: Floats) -> Floats:
        """The form at states `[n]` for a change of 1 and values of the shape."""
        known = self._known(values)
        return np.asarray(self.function(s, **{n: known[n] for n in _arguments(self.function)}))

    def text(self, meaning: str, values: Floats) -> str:
        """Its effect file. On friction, which parameters multiply, the shape has these values."""
        arguments, curve = _arguments(self.function), self.curve
        fixed = curve.form == "friction"
        free = self.parameters[:1] if fixed else self.parameters
        names = {p.name for p in free}
        constants = {n: v for n, v in self._known(values).items() if n in arguments}
        given = [n if n in names else n.upper() for n in arguments]
        if fixed:
            given[arguments.index("change")] = "1.0"
        call = f"{self.name}({curve.state}, {', '.join(given)})"
        above = [f"{n.upper()} = {v:.6g}\n" for n, v in constants.items() if n not in names]
        above += ["\n\n", _source(self.function), "\n"]
        return _file(curve, self.key, meaning, free, "".join(above), f"[{call}]" if fixed else call)

    def _known(self, values: Floats) -> dict[str, float]:
        """The arguments of the function, for a change of 1 and values of the shape."""
        shape = zip((p.name for p in self.parameters[1:]), values, strict=True)
        return {"low": self.curve.x[0], "high": self.curve.x[-1], **dict(shape), "change": 1.0}


def _arguments(form: Callable[..., Floats]) -> list[str]:
    """Those of a form, after the states."""
    return list(inspect.signature(form).parameters)[1:]


def free_curve(curve: Curve, places: Floats, spread: float) -> str:
    """The effect file of a curve that is what it will at the places, straight between them."""
    heights = [Parameter(f"h{k}", curve.value, 0.0, 0.0, spread, -9.0 * spread, 9.0 * spread)
        for k in range(len(places))]  # fmt: skip
    above = f"PLACES = {places.tolist()!r}\n"
    call = f"np.interp({curve.state}, PLACES, [{', '.join(p.name for p in heights)}])"
    if curve.form == "friction":
        call = f"[np.interp({curve.state}, PLACES, row) for row in np.eye({len(places)})]"
    return _file(curve, "free-curve", "A curve.", heights, above, call)


def _file(
    curve: Curve, key: str, meaning: str, parameters: Sequence[Parameter], above: str, call: str
) -> str:
    """An effect file whose function returns `call`; `above` stands before it."""
    first = {"friction": "columns", "speed_resistance": "speeds"}.get(curve.form, "track")
    named = [] if curve.form == "friction" else [p.name for p in parameters]
    column = "from avahazard.effects.covariate import number_column\n"
    rows = "".join(f"    {_written(p)},\n" for p in parameters)
    return f'''import numpy as np

{column if "number_column" in curve.state else ""}from avahazard.effects.effect import Parameter

KEY = {key!r}
MEANING = {meaning!r}
NEEDS = {list(curve.needs)!r}
PARAMETERS = [
{rows}]
{above}

def {curve.form}({", ".join([first, *named])}):
    """{curve.value.capitalize()} by {curve.of}."""
    return {call}
'''


def _written(p: Parameter) -> str:
    ends = f", low={p.low:.6g}, high={p.high:.6g}" if np.isfinite(p.low) else ""
    return (
        f'Parameter("{p.name}", "{p.unit}", neutral={p.neutral:.6g}, '
        f"prior_mean={p.prior_mean:.6g}, prior_sd={p.prior_sd:.6g}{ends})"
    )


def _source(function: Callable[..., Floats]) -> str:
    """The text of a function without its types."""
    made = ast.parse(inspect.getsource(function)).body[0]
    assert isinstance(made, ast.FunctionDef)
    made.returns = None
    for argument in made.args.args:
        argument.annotation = None
    return ast.unparse(made)


MOST = 4.0
"""Prior standard deviations that the change can be."""


def forms_of(curve: Curve, spread: float, taken: Container[str] = ()) -> list[LawForm]:
    """The forms that a curve may have, no key `taken`; `spread` is the prior sd of the change."""
    low, high = float(curve.x[0]), float(curve.x[-1])
    span, middle = high - low, 0.5 * (low + high)
    most = np.inf if curve.form == "friction" else MOST * spread
    change = Parameter("change", curve.value, 0.0, 0.0, spread, -most, most)
    shapes = {
        "exponent": ("", 1.5, 1.0, 0.2, 5.0),
        "threshold": (curve.unit, middle, 0.5 * span, low, high - 0.1 * span),
        "limit": (curve.unit, middle, 0.5 * span, low + 0.1 * span, high),
        "length": (curve.unit, 0.5 * span, 0.5 * span, 0.2 * span, 3.0 * span),
        "centre": (curve.unit, middle, 0.5 * span, low, high),
        "width": (curve.unit, 0.12 * span, 0.12 * span, 0.02 * span, 0.4 * span),
    }
    found = []
    for function in FORMULAS:
        if (function is constant and not curve.rests) or (function is power and low < 0.0):
            continue
        shape = []
        for name in _arguments(function):
            if name in shapes:
                unit, mean, sd, *ends = shapes[name]
                shape.append(Parameter(name, unit, mean, mean, sd, *ends))
        form = LawForm(function, curve, (change, *shape))
        while form.key in taken:
            form = replace(form, number=form.number + 1)
        found.append(form)
    return found
