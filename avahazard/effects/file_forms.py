"""The functions that an effect file may have, and how each becomes an effect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    Effect,
    FrictionEffect,
    FrontEffect,
    MotionEffect,
    Parameter,
    ShiftEffect,
)
from avahazard.effects.site import Site
from avahazard.physics.resistance import SPEEDS, Resistance
from avahazard.physics.terrain import Terrain
from avahazard.records.errors import AvahazardError

Function = Callable[..., Any]


@dataclass(frozen=True, slots=True)
class Form:
    """A function by its name, its first argument, and what it gives, in words.

    `tabulated`: the parameters are its further arguments, and tables are made over them.
    """

    name: str
    argument: str
    gives: str
    tabulated: bool = True


FORMS = (
    Form("friction", "columns", "a column over events for each parameter, times which it is added "
         "to log friction", tabulated=False),
    Form("friction_factor", "track", "what friction is multiplied by, in each cell of the path"),
    Form("resistance", "track", "a force per mass against the motion, m/s2, in each cell"),
    Form("drag", "track", "d of a force d u2 per mass, 1/m, in each cell"),
    Form("speed_factor", "speeds", "what friction is multiplied by, at each speed"),
    Form("speed_resistance", "speeds", "a force per mass against the motion, m/s2, at each speed"),
    Form("record_shift", "columns", "metres added to the recorded elevation of each event"),
    Form("front", "columns", "metres along the path by which each record is ahead of the block"),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class EffectTrack:
    """A path as an effect sees it: arrays over its cells `[n_cells]`.

    `x`, `y` (m) are the middle of each cell, `slope` its angle in degrees (> 0 downhill),
    `land_cover` a text (`open` where unknown); `path_id` and `section` are those of the path.
    """

    path_id: str
    section: str
    x: Floats
    y: Floats
    slope: Floats
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
        land_cover=site.cover(terrain),
    )


def build_effect(
    key: str, form: Form, function: Function, parameters: tuple[Parameter, ...], needs: Any
) -> Effect:
    """The effect of a file's function. Where data lack a column, the effect is not there."""
    call = _Call(key, form, function, parameters, tuple(needs))
    match form.name:
        case "friction":
            return FrictionEffect(key, parameters, call.design)
        case "record_shift":
            return ShiftEffect(key, parameters, call.metres)
        case "front":
            return FrontEffect(key, parameters, call.metres)
        case "speed_factor" | "speed_resistance":
            return MotionEffect(key, parameters, call.on_speed, speed_dependent=True)
    return MotionEffect(key, parameters, call.on_track)


@dataclass(frozen=True, slots=True)
class _Call:
    """A file's function, called with what it asks for; its faults become one message."""

    key: str
    form: Form
    function: Function
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
        return np.column_stack(
            [self._array(column, n, missing(columns, self.needs)) for column in many]
        )

    def metres(self, columns: EventColumns, values: Floats) -> Floats:
        n = len(columns)
        if self._lacks(columns) or self._neutral(values):
            return np.zeros(n)
        return self._array(self._result(columns, values), n, missing(columns, self.needs))

    def on_track(self, site: Site, resistance: Resistance, values: Floats) -> Resistance:
        terrain = site.terrain_for(resistance)
        result = self._result(track_of(site, terrain), values)
        given = self._array(result, terrain.n_cells)
        if self.form.name == "drag":
            return replace(resistance, drag=resistance.drag + given)
        if self.form.name == "resistance":
            return replace(resistance, constant=resistance.constant + given)
        return replace(resistance, factor=resistance.factor * given)

    def on_speed(self, _site: Site, resistance: Resistance, values: Floats) -> Resistance:
        given = self._array(self._result(SPEEDS, values), len(SPEEDS))
        if self.form.name == "speed_factor":
            before = resistance.speed_factor
            return replace(resistance, speed_factor=given if before is None else before * given)
        before = resistance.speed_constant
        return replace(resistance, speed_constant=given if before is None else before + given)

    def _neutral(self, values: Floats) -> bool:
        return bool(np.array_equal(values, [p.neutral for p in self.parameters]))

    def _lacks(self, columns: EventColumns) -> bool:
        """Whether a column that the file names is not among the data at all."""
        known = {*columns.numbers, *columns.texts, *columns.__slots__, *GIVEN}
        return any(need not in known for need in self.needs)

    def _result(self, first: object, values: Any) -> Any:
        try:
            return self.function(first, *(float(v) for v in values))
        except (Exception, SystemExit) as error:
            raise AvahazardError(
                f"Effect {self.key}: its function {self.form.name} fails: "
                f"{type(error).__name__}: {error}.",
                "Mend the effect file.",
            ) from error

    def _array(self, values: object, n: int, may_lack: Bools | None = None) -> Floats:
        """Numbers `[n]`; one number serves for all.

        nan is no effect where a number of the event is missing (`may_lack` `[n]`), else refused.
        """
        wrong = f"Effect {self.key}: {self.form.name} must give {n} numbers (or one)"
        try:
            if values is None:
                raise TypeError("it gives None")
            array = np.asarray(values, dtype=np.float64)
            filled = np.array(np.broadcast_to(array, (n,)))
        except (TypeError, ValueError) as error:
            raise AvahazardError(f"{wrong}: {error}.", "Mend the effect file.") from error
        lacks = np.isnan(filled) & (False if may_lack is None else may_lack)
        bad = ~np.isfinite(filled) & ~lacks
        if np.any(bad):
            at = int(np.argmax(bad))
            raise AvahazardError(
                f"{wrong}: number {at + 1} is {filled[at]}, and no column of NEEDS lacks there.",
                "Mend the effect file; columns in which numbers may be missing stand in NEEDS.",
            )
        return np.where(lacks, 0.0, filled)


def missing(columns: EventColumns, needs: tuple[str, ...]) -> Bools:
    """Events `[n_events]` that lack a number of the columns named in `needs`."""
    fields = {
        "date": (columns.year, columns.day_of_winter, columns.day, columns.winter),
        "volume_m3": (columns.log_volume,),
        "release_elevation_m": (columns.release_elevation,),
        "deposit_length_m": (columns.deposit_length,),
    }
    lacks = np.zeros(len(columns), dtype=np.bool_)
    for need in needs:
        known = (columns.numbers[need],) if need in columns.numbers else fields.get(need, ())
        for column in known:
            lacks |= np.isnan(column)
    return lacks


GIVEN = frozenset(
    ("profile", "land_cover", "date", "volume_m3", "release_elevation_m", "deposit_length_m",
     "section")
)  # fmt: skip
"""What all observations have a place for."""
