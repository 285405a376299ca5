"""The records' stated errors are too small or too large."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, RecordErrorEffect
from avahazard.effects.error_factor import HALF_OCTAVES, factor, log_factor
from avahazard.effects.needs import MIN_LEVEL
from avahazard.effects.site import Site


def _lacking(columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    if len(columns) >= 4 * MIN_LEVEL:
        return None
    return f"fewer than {4 * MIN_LEVEL} events"


def _build(_facts: Facts) -> RecordErrorEffect:
    return RecordErrorEffect("record-error", (log_factor(grid=HALF_OCTAVES),), scale=factor)


DEFINITION = Definition(
    key="record-error",
    meaning="The stated errors of the records are too small or too large, all by one factor. "
    "Such an error moves the friction that a record asks for more on some ground than on other, "
    "natural scatter does so alike, which tells them apart.",
    needs=f"{4 * MIN_LEVEL} events",
    build=_build,
    lacking=_lacking,
    order=164,
)
