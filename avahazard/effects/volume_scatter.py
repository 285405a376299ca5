"""Scatter that changes with volume."""

from __future__ import annotations

from avahazard.effects.effect import Definition, Effect, Facts, Setting
from avahazard.effects.needs import needs_volume


def _build(_facts: Facts) -> Effect:
    return Effect("volume-scatter", ())


DEFINITION = Definition(
    key="volume-scatter",
    meaning="Large avalanches differ less from each other than small ones do (or more), so the "
    "scatter of friction is σ(V) = a' exp(-n' V), up to the volume that nine events in ten stay "
    "under and constant beyond. The mean stays, the intervals change.",
    needs="volume",
    build=_build,
    lacking=needs_volume,
    changes=Setting("scatter", "the scatter of friction", value="volume"),
    order=80,
)
