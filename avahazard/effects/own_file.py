"""A user's own effect, from a file of plain Python.

The file says KEY, MEANING, NEEDS and PARAMETERS, and has exactly one of the functions named in
`FORMS`. It becomes a definition with the same rights as one of the catalogue.
"""

import ast
import inspect
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats
from avahazard.effects.catalogue import catalogue
from avahazard.effects.columns import EventColumns
from avahazard.effects.covariate import number_column, text_column
from avahazard.effects.effect import (
    Definition,
    Effect,
    FrictionEffect,
    FrontEffect,
    MotionEffect,
    Parameter,
    ShiftEffect,
    Sites,
    needs_profile,
)
from avahazard.effects.motion import STATES
from avahazard.effects.site import Site
from avahazard.physics.cells import SPEEDS, Resistance
from avahazard.physics.terrain import Terrain
from avahazard.records.errors import AvahazardError

FORMS = {
    "friction": ("columns", ""),
    "friction_factor": ("track", "factor"),
    "added_friction": ("track", "offset"),
    "resistance": ("track", "constant"),
    "drag": ("track", "drag"),
    "speed_factor": ("speeds", "speed_factor"),
    "speed_resistance": ("speeds", "speed_constant"),
    "record_shift": ("columns", ""),
    "front": ("columns", ""),
}
"""The functions that a file may have, as the template explains them: their first argument, and the
term of `Resistance` that those on the motion change. All but `friction`, which the parameters
multiply, take the parameters by name after it."""
MIN_KNOWN = 5
GIVEN = frozenset(
    ("profile", "land_cover", "date", "volume_m3", "release_elevation_m", "deposit_length_m",
     "section")
)  # fmt: skip
"""What all observations have a place for."""
MEND = "Correct the effect file."


def read_text(file: Path) -> str:
    """The text of an effect file, which is not run. Raises `AvahazardError` without one."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = (error.strerror if isinstance(error, OSError) else None) or error
        raise AvahazardError(
            f"The effect file {file} cannot be read: {why}.",
            "A template: avahazard effect new FILE.",
        ) from error


def declared_key(text: str) -> str | None:
    """The KEY that the text of an effect file gives as a literal; the file is not run."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return None
    for node in (part for part in tree.body if isinstance(part, ast.Assign)):
        for target in node.targets:
            names, values = [target], [node.value]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                names, values = target.elts, node.value.elts
            for name, value in zip(names, values, strict=False):
                match name, value:
                    case ast.Name(id="KEY"), ast.Constant(value=str(key)):
                        return key.strip()
    return None


def definition_from(text: str, name: str) -> Definition:
    """The definition that a file's text makes, which is run; refused where it lacks something."""
    module: dict[str, Any] = {"__name__": "effect_file", "__file__": name}
    try:
        # The user's own program, and run only where the user names it (SECURITY.md).
        exec(compile(text, name, "exec"), module)  # noqa: S102
    except (Exception, SystemExit) as error:
        trace = reversed(traceback.extract_tb(error.__traceback__))
        lines = (frame.lineno for frame in trace if frame.filename == name)
        line = getattr(error, "lineno", None) or next(lines, None)
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
    form = _form(module, name)
    parameters = _parameters(module, form, name)
    wanted = [FORMS[form][0], *(p.name for p in parameters if form != "friction")]
    if list(inspect.signature(module[form]).parameters) != wanted:
        raise AvahazardError(
            f"{name}: the function {form} does not take the right arguments.",
            f"Begin it with: def {form}({', '.join(wanted)}):",
        )
    effect = _effect(_Call(key, form, module[form], parameters, needs))
    return Definition(
        key=key,
        meaning=_text(module, "MEANING", name),
        needs=", ".join(needs) or "nothing",
        build=lambda _: effect,
        lacking=partial(_lacking, needs),
        # Which columns a user's function reads, and what it does to speed, is not known: it may.
        event_columns=True,
        uses_volume=True,
        limits_speed=True,
        text=text,
    )


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


def _form(module: dict[str, Any], name: str) -> str:
    found = [form for form in FORMS if callable(module.get(form))]
    if len(found) != 1:
        have = f"has {' and '.join(found)}" if found else "has none of them"
        raise AvahazardError(
            f"{name}: exactly one function says what the effect acts on; the file {have}.",
            f"They are: {', '.join(FORMS)}.",
        )
    return found[0]


def _parameters(module: dict[str, Any], form: str, name: str) -> tuple[Parameter, ...]:
    given = module.get("PARAMETERS")
    right = isinstance(given, list | tuple) and all(isinstance(p, Parameter) for p in given)
    if not (right and given):
        raise AvahazardError(
            f"{name}: PARAMETERS is missing or no list of Parameter(...).",
            'Write PARAMETERS = [Parameter("north", "log friction", neutral=0.0, prior_mean=0.0, '
            "prior_sd=0.2)].",
        )
    return tuple(_checked(p, form, name) for p in given)


def _checked(p: Parameter, form: str, name: str) -> Parameter:
    tabulated = form != "friction"
    wrong = ""
    if not p.name.isidentifier():
        wrong = "its name must be one word of letters, digits and _"
    elif not (np.isfinite(p.prior_mean) and np.isfinite(p.neutral) and 0 < p.prior_sd < np.inf):
        wrong = "neutral, prior_mean and prior_sd > 0 must be numbers"
    elif not p.low <= p.neutral <= p.high or not p.low <= p.prior_mean <= p.high:
        wrong = "neutral and prior_mean must lie in [low, high]"
    elif not tabulated and p.neutral != 0.0:
        wrong = "friction is multiplied by the parameter, so that neutral must be 0"
    elif tabulated and not (np.isfinite(p.low) and np.isfinite(p.high) and p.low < p.high):
        wrong = f"{form} is tabulated over it and needs low < high"
    if wrong:
        raise AvahazardError(f"{name}: parameter {p.name!r}: {wrong}.")
    return p


def _lacking(needs: tuple[str, ...], columns: EventColumns, sites: Sites) -> str | None:
    for need in needs:
        if need == "profile":
            if lack := needs_profile(columns, sites):
                return lack
        elif need == "land_cover":
            if all(site.profile.land_cover is None for site in sites):
                return "no profile has a land_cover"
        elif (n := known_values(columns, need)) < MIN_KNOWN:
            return f"{n} events have a value of {need}"
    return None


def known_values(columns: EventColumns, name: str) -> int:
    """Number of events with a value in a column."""
    numbers = columns.year if name == "date" else number_column(columns, name)
    if numbers is not None:
        return int(np.sum(np.isfinite(numbers)))
    texts = text_column(columns, name)
    return 0 if texts is None else int(np.sum(texts != ""))


@dataclass(frozen=True, slots=True, eq=False)
class EffectTrack:
    """A path as an effect sees it: arrays over its cells `[n_cells]`.

    `x`, `y` (m) are the middle of each cell, `slope` its angle in degrees (> 0 downhill),
    `elevation` (m), `distance` (m) along the path and `curvature` (1/km, > 0 where concave) its
    state as the forces of the state have it, `land_cover` a text (`open` where unknown);
    `path_id` and `section` are those of the path.
    """

    path_id: str
    section: str
    x: Floats
    y: Floats
    slope: Floats
    elevation: Floats
    distance: Floats
    curvature: Floats
    land_cover: NDArray[np.str_]


def track_of(site: Site, terrain: Terrain) -> EffectTrack:
    """The track of a site, over the cells of one of its terrains."""
    x = terrain.middle_x
    return EffectTrack(
        path_id=site.path.path_id,
        section=site.path.section or "",
        x=x,
        y=terrain.middle_y,
        slope=np.degrees(-np.arctan(site.smooth.derivatives(x)[1])),
        **{name: STATES[name][2](terrain) for name in ("elevation", "distance", "curvature")},
        land_cover=site.cover(x),
    )


@dataclass(frozen=True, slots=True)
class _Call:
    """A file's function and its faults in one message; no effect without a column that it needs."""

    key: str
    form: str
    function: Callable[..., Any]
    parameters: tuple[Parameter, ...]
    needs: tuple[str, ...]

    def design(self, columns: EventColumns) -> Floats:
        n = len(columns)
        if self._lacks(columns):
            return np.zeros((n, len(self.parameters)))
        given = self._result(columns, ())
        many = given if isinstance(given, list | tuple) else [given]
        if len(many) != len(self.parameters):
            raise AvahazardError(
                f"Effect {self.key}: friction gives {len(many)} columns for "
                f"{len(self.parameters)} parameters.",
                "Return one column over the events for each parameter, in their order.",
            )
        lacks = self._missing(columns)
        return np.column_stack([self._array(column, n, lacks) for column in many])

    def metres(self, columns: EventColumns, values: Floats) -> Floats:
        neutral = np.array_equal(values, [p.neutral for p in self.parameters])
        if neutral or self._lacks(columns):
            return np.zeros(len(columns))
        return self._array(self._result(columns, values), len(columns), self._missing(columns))

    def resistance(self, site: Site, resistance: Resistance, values: Floats) -> Resistance:
        of, term = FORMS[self.form]
        before = getattr(resistance, term)
        first = track_of(site, site.terrain_for(resistance)) if of == "track" else SPEEDS
        given = self._array(self._result(first, values), len(before))
        after = before * given if term.endswith("factor") else before + given
        return replace(resistance, **{term: after})

    def _lacks(self, columns: EventColumns) -> bool:
        """Whether a column that the file names is not among the data at all."""
        known = {*columns.texts, *columns.__slots__, *GIVEN}
        return any(n not in known and number_column(columns, n) is None for n in self.needs)

    def _missing(self, columns: EventColumns) -> Bools:
        """Events `[n_events]` that lack a number of the columns that the file needs."""
        dates = (columns.year, columns.day_of_winter, columns.day, columns.winter)
        lacks = np.zeros(len(columns), dtype=np.bool_)
        for need in self.needs:
            for numbers in dates if need == "date" else (number_column(columns, need),):
                if numbers is not None:
                    lacks |= np.isnan(numbers)
        return lacks

    def _result(self, first: object, values: Any) -> Any:
        try:
            return self.function(first, *(float(v) for v in values))
        except (Exception, SystemExit) as error:
            raise AvahazardError(
                f"Effect {self.key}: its function {self.form} fails: "
                f"{type(error).__name__}: {error}.",
                MEND,
            ) from error

    def _array(self, values: object, n: int, may_lack: Bools | None = None) -> Floats:
        """Numbers `[n]`; one number serves for all.

        nan is no effect where a number of the event is missing (`may_lack` `[n]`), else refused.
        """
        wrong = f"Effect {self.key}: {self.form} must give {n} numbers (or one)"
        try:
            if values is None:
                raise TypeError("it gives None")
            filled = np.array(np.broadcast_to(np.asarray(values, dtype=np.float64), (n,)))
        except (TypeError, ValueError) as error:
            raise AvahazardError(f"{wrong}: {error}.", MEND) from error
        lacks = np.isnan(filled) & (False if may_lack is None else may_lack)
        bad = ~np.isfinite(filled) & ~lacks
        if np.any(bad):
            at = int(np.argmax(bad))
            raise AvahazardError(
                f"{wrong}: that of event {at + 1} is {filled[at]}, though its columns are known.",
                "Correct the effect file; columns in which numbers may be missing stand in NEEDS.",
            )
        return np.where(lacks, 0.0, filled)


def _effect(call: _Call) -> Effect:
    match call.form:
        case "friction":
            return FrictionEffect(call.key, call.parameters, call.design)
        case "record_shift":
            return ShiftEffect(call.key, call.parameters, call.metres)
        case "front":
            return FrontEffect(call.key, call.parameters, call.metres)
    by_speed = FORMS[call.form][0] == "speeds"
    return MotionEffect(call.key, call.parameters, call.resistance, speed_dependent=by_speed)


TEMPLATE = Path(__file__).with_name("own_effect.txt").read_text("utf-8")
"""A file to begin with."""
