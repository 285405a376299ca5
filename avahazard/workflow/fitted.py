"""A stored model made ready to be set against records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import PATH_SCATTER
from avahazard.inference.model.observations import Observations
from avahazard.inference.model.volumes import VolumeNodes
from avahazard.records.collection import Records
from avahazard.workflow.stored_model import StoredFit, posterior_for

Floats = NDArray[np.float64]


def fitted_posterior(
    stored: StoredFit, records: Records, prior: Observations | None = None
) -> Posterior:
    """The model's posterior over `records`; see `posterior_for`.

    The paper's methods take volumes as exact, and so does what they predict.
    """
    observations, posterior = posterior_for(stored, records, prior)
    if stored.method == "marginal":
        return posterior
    observations = replace(observations, volumes=exact_volumes(observations))
    return Posterior(observations, stored.specification, posterior.effects, stored.grids)


def exact_volumes(observations: Observations) -> VolumeNodes:
    """One node at each recorded volume; an event without one keeps the middle of its path's."""
    recorded = observations.columns.log_volume
    mean = np.where(np.isfinite(recorded), recorded, observations.volumes.mean)
    return replace(
        observations.volumes,
        log_volume=mean[:, None],
        weight=np.ones((len(mean), 1)),
        mean=mean,
        sd=np.where(np.isfinite(recorded), 0.0, observations.volumes.sd),
    )


def offset_array(
    posterior: Posterior,
    coordinates: Floats,
    offsets: Mapping[str, Floats],
    rng: np.random.Generator,
) -> Floats | None:
    """Draws of path offsets `[n_draws, n_groups]`, None without a path effect.

    A path that the model has not seen gets offsets from the spread between paths.
    """
    place = posterior.layout.path_scatter
    if posterior.groups is None or place is None:
        return None
    tau = PATH_SCATTER * coordinates[:, place]
    return np.column_stack(
        [
            offsets[path] if path in offsets else tau * rng.standard_normal(len(tau))
            for path in posterior.observations.columns.paths
        ]
    )
