"""What a stored model takes from the avalanches that it is applied to, and a path by it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.path_hazard import PathHazard, path_hazard
from avahazard.inference.model.laws import law
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.records.collection import Records
from avahazard.workflow.stored.fit import Fit


def takes_event_columns(stored: Fit) -> bool:
    """Whether the model's friction or front depends on columns of the event itself."""
    return any(entry.event_columns for entry in stored.definitions)


def ignores_volume(stored: Fit) -> bool:
    """Whether the model gives the same runout for every volume."""
    specification = stored.specification
    return (
        not law(specification.law).uses_volume
        and specification.scatter == "constant"
        and not any(entry.uses_volume for entry in stored.definitions)
    )


@dataclass(frozen=True, slots=True, eq=False)
class AppliedModel:
    """A stored model to be applied to paths, without what its own events were run on: small."""

    fitted: FittedModel
    event_columns: bool
    volume_matters: bool

    def path(
        self,
        records: Records,
        path_id: str,
        volumes: EventVolumes | None,
        at: Sequence[float] = (),
        *,
        seed: int,
    ) -> PathHazard:
        """What comes down a path, whose `records` these are (`path_hazard`)."""
        return path_hazard(
            self.fitted,
            records,
            path_id,
            volumes,
            at,
            event_columns=self.event_columns,
            volume_matters=self.volume_matters,
            seed=seed,
        )


def applied_model(stored: Fit) -> AppliedModel:
    """A stored model without its tables."""
    return AppliedModel(
        replace(stored.model, posterior=stored.model.posterior.bare()),
        takes_event_columns(stored),
        not ignores_volume(stored),
    )
