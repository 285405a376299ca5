"""Another law of friction against volume than the model's."""

from __future__ import annotations

from avahazard.effects.effect import Definition, Effect, Facts, Setting
from avahazard.effects.needs import needs_volume


def _build(_facts: Facts) -> Effect:
    return Effect("volume-law", ())


DEFINITION = Definition(
    key="volume-law",
    meaning="Friction falls with volume along another curve than the model's law. The most "
    "likely of the other laws is taken.",
    needs="volume",
    build=_build,
    lacking=needs_volume,
    changes=Setting("law", "the law of friction against volume"),
    order=70,
)
