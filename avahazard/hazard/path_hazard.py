"""All that the runouts, speeds and zones of one path follow from, built once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from avahazard.effects.effect import FrontEffect, of_kind
from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.classes_to_come import classes_to_come, path_release_zone
from avahazard.hazard.event_volumes import ANY_VOLUME_M3, EventVolumes, one_volume, with_volumes
from avahazard.hazard.posterior_draws import (
    GroupRuns,
    PosteriorDraws,
    group_runs,
    group_tables,
    posterior_draws,
)
from avahazard.hazard.recorded_stops import RecordedStops, recorded_stops_of
from avahazard.hazard.unseen import limits_of_sight, with_unseen
from avahazard.hazard.volume_frequency import N_DRAWS
from avahazard.hazard.volume_friction import (
    RisingFriction,
    VolumeFriction,
    friction_of_volumes,
    rising_friction,
    volume_frictions,
)
from avahazard.inference.likelihood.predicted import front_ahead
from avahazard.inference.model.friction_scatter import shifted
from avahazard.inference.model.observations import build_observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.records.collection import Records
from avahazard.records.lookup import of_path

MAX_PARAMETERS = 4000
"""Posterior draws that the bounds of a volume take, evenly, of those of the model."""


@dataclass(frozen=True, slots=True)
class Varying:
    """What makes a difference from avalanche to avalanche of a path, besides friction's scatter."""

    release: bool = False
    columns: bool = False
    volume: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class PathHazard:
    """One path by one model: the unit of work of `hazard` and `zones`, arrays all through.

    `avalanches` are all that come down it, of every volume, at the path's rate (once a year where
    that is not `rate_known`). `draws` are those for the bounds of single volumes, `at_volume` the
    friction of each (m3). Both take the tables of one set of runs. `offset_unknown`: paths differ
    by the model, and it does not know by how much this one does. `rising`: how sure it is that
    friction rises with volume.
    """

    path_id: str
    avalanches: Avalanches
    draws: PosteriorDraws
    at_volume: Mapping[float, VolumeFriction]
    rate_known: bool
    varying: Varying
    offset_unknown: bool
    rising: RisingFriction | None = None
    recorded: RecordedStops = field(default_factory=RecordedStops)


def path_hazard(
    model: FittedModel,
    records: Records,
    path_id: str,
    volumes: EventVolumes | None,
    at: Sequence[float] = (),
    *,
    event_columns: bool,
    volume_matters: bool,
    seed: int,
) -> PathHazard:
    """Apply a calibrated model to avalanches to come on a path.

    `records` are those of the database, for the releases and columns of such avalanches; the model
    takes columns of the event or not, and volume matters to it or not. Otherwise as
    `hazard_of_classes`.
    """
    # Of the path's own volumes: what is asked for besides must change no other row.
    mixed = _mixed(volumes, () if volumes is not None else at)
    middle = float(np.exp(np.median(mixed.log_volume)))
    classes = classes_to_come(records, path_id, middle, event_columns=event_columns)
    mine = of_path(records, path_id)
    there = Records(mine.paths, mine.profiles, classes)
    here = model.on(build_observations(there, model.observations))
    found = hazard_of_classes(
        here,
        path_id,
        volumes,
        at,
        Varying(path_release_zone(records, path_id) is not None, event_columns, volume_matters),
        seed=seed,
    )
    return replace(
        found,
        rising=rising_friction(here, found.draws.u, model.observations.columns.log_volume),
        recorded=recorded_stops_of(records, path_id, found.avalanches.site.smooth),
    )


def hazard_of_classes(
    model: FittedModel,
    path_id: str,
    volumes: EventVolumes | None,
    at: Sequence[float] = (),
    varying: Varying = Varying(),
    *,
    seed: int,
) -> PathHazard:
    """What a path has by a model on its classes of avalanches to come; the block is run here.

    The events of `model` are one for each class, all of this path and equally frequent. `volumes`
    are the rate and volumes of its avalanches, None where nothing is known; `at` the volumes (m3)
    that bounds are wanted of. The posterior of the model is spread over the draws of `volumes`,
    which know nothing of each other.
    """
    mixed = _mixed(volumes, at)
    groups = group_runs(model)
    many = posterior_draws(model, groups, path_id, MAX_PARAMETERS)
    avalanches = _avalanches(model, groups, path_id, mixed, seed)
    # Runs know nothing of volumes; only how far the front is ahead may.
    alike = not of_kind(model.posterior.effects, FrontEffect)
    tables = avalanches.tables if alike else None
    return PathHazard(
        path_id=path_id,
        avalanches=avalanches,
        draws=many,
        at_volume=volume_frictions(model, groups, many.u, tuple(dict.fromkeys(at)), tables),
        rate_known=volumes is not None,
        varying=varying,
        offset_unknown=many.tau is not None and many.offset is None,
    )


def _avalanches(
    model: FittedModel, groups: GroupRuns, path_id: str, volumes: EventVolumes, seed: int
) -> Avalanches:
    posterior, observations = model.posterior, model.observations
    site, n_classes, n = observations.sites[0], observations.n_events, len(volumes.rate)
    draws = posterior_draws(model, groups, path_id, n)
    location, scatter = friction_of_volumes(posterior, draws.u, np.exp(volumes.log_volume))
    shift = draws.shift(generator(seed, "avalanches", path_id))[:, None, None]
    in_log = posterior.layout.log_scatter
    location = shifted(location, shift, in_log)
    # Fewer draws of the model than of the volumes serve several times.
    again = slice(None) if len(draws.u) == n else np.arange(n) * len(draws.u) // n
    known = Avalanches(
        site=site,
        release=observations.release,
        volumes=volumes,
        class_share=np.full(n_classes, 1.0 / n_classes),
        location=location[again],
        scatter=scatter[again],
        group=draws.group[again],
        tables=group_tables(model, groups, observations),
        values=groups.values,
        resistances=tuple(posterior.resistance(site, values) for values in groups.values),
        ahead=tuple(
            front_ahead(posterior.observations, posterior.effects, values)
            for values in groups.values
        ),
        in_log=in_log,
        student=model.specification.tails == "student",
        sigma_m=None if draws.sigma_m is None else draws.sigma_m[again],
    )
    return with_unseen(known, limits_of_sight(posterior, groups.values))


def _mixed(volumes: EventVolumes | None, at: Sequence[float]) -> EventVolumes:
    """All volumes, with nodes at those that bounds are wanted of."""
    return with_volumes(
        volumes or one_volume([*at, ANY_VOLUME_M3][0], N_DRAWS), np.log(np.asarray(at, np.float64))
    )
