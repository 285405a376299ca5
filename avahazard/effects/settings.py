"""Effects that are settings of the model: nothing is built for them."""

from __future__ import annotations

import numpy as np

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Effect, Setting, Sites, needs_profile


def _needs_volume(columns: EventColumns, _sites: Sites) -> str | None:
    known = columns.log_volume[np.isfinite(columns.log_volume)]
    return None if len(known) and np.ptp(known) > 0 else "the events have no (different) volumes"


CENTRIFUGAL = Definition(
    key="centrifugal",
    meaning="In a hollow the path turns under the block and presses on it, so that friction "
    "grows with speed and curvature; over a crest it is lighter. It is in the base model and can "
    "be left out.",
    needs="profile",
    build=lambda _: Effect("centrifugal", ()),
    lacking=needs_profile,
    changes=Setting("centrifugal", "the motion", value=True, without=False),
    order=10,
)
VOLUME_LAW = Definition(
    key="volume-law",
    meaning="Friction falls with volume along another curve than the model's law. The most "
    "likely of the other laws is taken.",
    needs="volume",
    build=lambda _: Effect("volume-law", ()),
    lacking=_needs_volume,
    changes=Setting("law", "the law of friction against volume"),
    order=70,
)
VOLUME_SCATTER = Definition(
    key="volume-scatter",
    meaning="Large avalanches differ less from each other than small ones do (or more), so the "
    "scatter of friction is σ(V) = a' exp(-n' V), up to the volume that nine events in ten stay "
    "under and constant beyond. The mean stays, the intervals change.",
    needs="volume",
    build=lambda _: Effect("volume-scatter", ()),
    lacking=_needs_volume,
    changes=Setting("scatter", "the scatter of friction", value="volume"),
    order=80,
)
