"""What else could explain what a candidate does: stops unseen, or misstated errors of volumes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avahazard.criticism.diagnosis.misstated_volumes import by_misstated_volumes
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.unseen_stops import by_what_is_seen
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition
from avahazard.inference.model.observations import Observations

READINGS = (by_what_is_seen, by_misstated_volumes)


def read_otherwise(
    observations: Observations,
    own: Sequence[Definition],
    base: Refit,
    fits: Mapping[str, Refit],
    key: str,
    screening: Screening,
) -> tuple[str, ...]:
    """Effects on the record that leave candidate `key` too little evidence over `base`.

    `fits` are `base` with each candidate by itself.
    """
    found = (reading(observations, own, base, fits, key, screening) for reading in READINGS)
    return tuple(other for other in found if other is not None)
