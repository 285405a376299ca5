"""Curvature loads the bed: part of the base model."""

from __future__ import annotations

from avahazard.effects.effect import Definition, Effect, Facts, Setting
from avahazard.effects.needs import needs_profile


def _build(_facts: Facts) -> Effect:
    return Effect("centrifugal", ())


DEFINITION = Definition(
    key="centrifugal",
    meaning="In a hollow the path turns under the block and presses on it, so that friction "
    "grows with speed and curvature; over a crest it is lighter. It is in the base model and can "
    "be left out.",
    needs="profile",
    build=_build,
    lacking=needs_profile,
    changes=Setting("centrifugal", "the motion", value=True, without=False),
    order=10,
)
