"""The error budgets of models as the parts of stacked bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avahazard.criticism.scoring.error_budget import UNEXPLAINED
from avahazard.report.language import ENGLISH, Language
from avahazard.results.comparison import Comparison

COLORS = {
    "record": "#BBBBBB",
    "volume": "#56B4E9",
    "release": "#0072B2",
    "scatter": "#E69F00",
    "parameters": "#CC79A7",
    UNEXPLAINED: "#D55E00",
}
EXPLAINED = ("#009E73", "#66C2A5", "#1B7837", "#A6D96A")
"""Colours of what added effects explain."""


def part_words(source: str, language: Language = ENGLISH) -> str:
    """A source of error as people call it."""
    say = language.say
    known = {
        "record": say("errors of the records"),
        "volume": say("errors of the volumes"),
        "release": say("errors of the releases"),
        "scatter": say("natural scatter"),
        "parameters": say("parameters"),
        UNEXPLAINED: say("unexplained"),
    }
    if source in known:
        return known[source]
    return say("explained by {effect}", effect=language.effect(source))


def bars(
    names: Sequence[str], comparisons: Mapping[str, Comparison]
) -> dict[str, dict[str, float]]:
    """Metres by source of every compared model that has a budget, in the order of `names`."""
    return {
        name: {part.source: part.rms_m for part in comparisons[name].budget}
        for name in names
        if name in comparisons and comparisons[name].budget
    }


def parts_in_order(found: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """The colour of every source: those of all models, each effect's, the unexplained last."""
    sources = dict.fromkeys(source for bar in found.values() for source in bar)
    effects = [source for source in sources if source not in COLORS]
    known = [source for source in COLORS if source in sources and source != UNEXPLAINED]
    colors = {source: COLORS[source] for source in known}
    colors |= {source: EXPLAINED[k % len(EXPLAINED)] for k, source in enumerate(effects)}
    return colors | ({UNEXPLAINED: COLORS[UNEXPLAINED]} if UNEXPLAINED in sources else {})
