"""What a stored model takes from the avalanches that it is applied to, and a path by it."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.path_hazard import PathHazard, path_hazard
from avahazard.workflow.stored.model import StoredFit


def takes_event_columns(stored: StoredFit) -> bool:
    """Whether the model's friction or front depends on columns of the event itself."""
    return any(entry.event_columns for entry in stored.definitions)


def ignores_volume(stored: StoredFit) -> bool:
    """Whether the model gives the same runout for every volume."""
    specification = stored.specification
    return (
        specification.law == "constant"
        and specification.scatter == "constant"
        and not any(entry.uses_volume for entry in stored.definitions)
    )


def stored_path_hazard(
    stored: StoredFit,
    path_id: str,
    volumes: EventVolumes | None,
    at: Sequence[float] = (),
    *,
    seed: int,
) -> PathHazard:
    """What comes down a path by a stored model (`path_hazard`)."""
    return path_hazard(
        stored.model,
        stored.records,
        path_id,
        volumes,
        at,
        event_columns=takes_event_columns(stored),
        volume_matters=not ignores_volume(stored),
        seed=seed,
    )
