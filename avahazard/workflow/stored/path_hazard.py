"""What a stored model takes from the avalanches that it is applied to, and a path by it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from avahazard.effects.site import Site
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.path_hazard import PathHazard, path_hazard
from avahazard.inference.model.laws import law
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.records.collection import Records
from avahazard.workflow.stored.model import StoredFit


def takes_event_columns(stored: StoredFit) -> bool:
    """Whether the model's friction or front depends on columns of the event itself."""
    return any(entry.event_columns for entry in stored.definitions)


def ignores_volume(stored: StoredFit) -> bool:
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
        site: Site | None,
        path_id: str,
        volumes: EventVolumes | None,
        at: Sequence[float] = (),
        *,
        seed: int,
    ) -> PathHazard:
        """What comes down a path (`path_hazard`).

        `records` are those of the path, `site` its own of the calibration, None where it had none.
        """
        bare = self.fitted.posterior.bare(() if site is None else (site,))
        return path_hazard(
            replace(self.fitted, posterior=bare),
            records,
            path_id,
            volumes,
            at,
            event_columns=self.event_columns,
            volume_matters=self.volume_matters,
            seed=seed,
        )


def applied_model(stored: StoredFit) -> AppliedModel:
    """A stored model without its sites and tables."""
    return AppliedModel(
        replace(stored.model, posterior=stored.model.posterior.bare()),
        takes_event_columns(stored),
        not ignores_volume(stored),
    )


def for_paths(stored: StoredFit) -> StoredFit:
    """A stored model to be applied path by path: its sites have no terrains, it has no tables.

    Those of all paths would be held as long as the work goes on.
    """
    sites = tuple(replace(site) for site in stored.model.observations.sites)
    return replace(
        stored, model=replace(stored.model, posterior=stored.model.posterior.bare(sites))
    )
