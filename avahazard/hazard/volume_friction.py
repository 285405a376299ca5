"""Friction and runs of the avalanches of single volumes, and whether it rises with volume."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.classes_to_come import at_volumes
from avahazard.hazard.posterior_draws import GroupRuns, group_tables
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.prediction.fitted_model import FittedModel


@dataclass(frozen=True, slots=True, eq=False)
class VolumeFriction:
    """Friction and runs of the avalanches of one volume.

    `location`, `scatter` `[n_parameters, n_classes]` as `FrictionModel.of_future_events`, without
    the path's offset; `tables` `[n_groups]` as in `Avalanches`.
    """

    location: Floats
    scatter: Floats
    tables: tuple[Predicted, ...]


@dataclass(frozen=True, slots=True)
class RisingFriction:
    """Share of the draws in which friction is higher at `largest_m3` than at `smallest_m3`.

    These are the ends of the recorded volumes.
    """

    share: float
    smallest_m3: float
    largest_m3: float


def volume_frictions(
    model: FittedModel,
    groups: GroupRuns,
    u: Floats,
    at: tuple[float, ...],
    tables: tuple[Predicted, ...] | None,
) -> dict[float, VolumeFriction]:
    """Friction of each of the volumes `at` (m3); `tables` are theirs, where all have the same."""
    if not at:
        return {}
    location, scatter = friction_of_volumes(model.posterior, u, np.array(at))
    found = {}
    for k, volume in enumerate(at):
        own = tables
        if own is None:
            own = group_tables(model, groups, at_volumes(model.observations, np.array([volume])))
        found[volume] = VolumeFriction(location[:, :, k], scatter[:, :, k], own)
    return found


def rising_friction(here: FittedModel, u: Floats, log_volume: Floats) -> RisingFriction | None:
    """Of draws `u` `[n_parameters, n_slots]` over log volumes `[n_events]` (nan: not recorded)."""
    known = log_volume[np.isfinite(log_volume)]
    if not len(known) or np.ptp(known) == 0.0:
        return None
    ends = np.exp([known.min(), known.max()])
    location, _ = friction_of_volumes(here.posterior, u, ends)
    rises = location[:, :, 1].mean(axis=1) > location[:, :, 0].mean(axis=1)
    return RisingFriction(float(np.mean(rises)), float(ends[0]), float(ends[1]))


def friction_of_volumes(posterior: Posterior, u: Floats, volume: Floats) -> tuple[Floats, Floats]:
    """Location and scatter `[n_parameters, n_classes, n_volumes]` at volumes (m3) `[n_volumes]`."""
    observations = posterior.observations
    shape = (len(u), observations.n_events, len(volume))
    columns = at_volumes(observations, volume).columns
    every = np.tile(volume, observations.n_events)
    location, scatter = posterior.friction.of_future_events(u, every, columns)
    return location.reshape(shape), scatter.reshape(shape)
