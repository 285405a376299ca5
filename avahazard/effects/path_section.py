"""Channelled against open paths."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, FrictionEffect
from avahazard.effects.levels import level_effect, level_facts, level_lacking, level_words
from avahazard.effects.site import Site


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    return level_lacking(columns, "section")


def _facts(columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    return level_facts(columns, "section")


def _seen_in(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    return level_words(columns, "section")


def _build(facts: Facts) -> FrictionEffect:
    return level_effect("path-section", "section", facts)


DEFINITION = Definition(
    key="path-section",
    meaning="A channel confines the flow and keeps it deep, an open slope lets it spread. The "
    "two kinds of path then have different friction.",
    needs="section",
    build=_build,
    lacking=_lacking,
    facts=_facts,
    seen_in=_seen_in,
    order=100,
)
