"""Friction by snow type."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, FrictionEffect
from avahazard.effects.levels import level_effect, level_facts, level_lacking, level_words
from avahazard.effects.site import Site

COLUMN = "snow_type"


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    return level_lacking(columns, COLUMN)


def _facts(columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    return level_facts(columns, COLUMN)


def _seen_in(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    return level_words(columns, COLUMN)


def _build(facts: Facts) -> FrictionEffect:
    return level_effect("snow-type", COLUMN, facts)


DEFINITION = Definition(
    key="snow-type",
    meaning="Wet, dry and mixed snow rub differently on the bed. Each type has its own level of "
    "friction, given against the most common type.",
    needs="snow_type",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    seen_in=_seen_in,
    event_columns=True,
    column=COLUMN,
    order=90,
)
