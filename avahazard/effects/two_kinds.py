"""Two kinds of avalanche that nobody recorded: friction scatters about two places."""

from __future__ import annotations

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, KindsEffect, Parameter, Sites

FEWEST = 30
"""Fewest events that can tell two kinds from one."""
RAREST = 0.15
"""Share of the rarer kind, at least: what is rarer passes for heavy tails or wrong records."""
LEVEL = 0.005
"""Level at which the diagnosis tests it."""
SHIFT_SD = 0.3
"""Prior standard deviation of the shift, that of the friction of wet snow against dry."""
PARAMETERS = (
    Parameter("share", "of the avalanches", 0.5, 0.5, 0.3, RAREST, 1.0 - RAREST),
    Parameter("shift", "log friction", 0.0, 0.0, SHIFT_SD, -1.5, 0.0),
)


def _few_events(columns: EventColumns, _sites: Sites) -> str | None:
    return None if len(columns) >= FEWEST else f"fewer than {FEWEST} events"


TWO_KINDS = Definition(
    key="two-kinds",
    meaning="Avalanches are of two kinds that no column records. Friction is a mixture: the log "
    "friction of a share of them lies lower than that of the others, and the mean of both follows "
    "the law.",
    needs=f"{FEWEST} events",
    build=lambda _: KindsEffect("two-kinds", PARAMETERS),
    lacking=_few_events,
    level_alone=LEVEL,
    order=142,
)
