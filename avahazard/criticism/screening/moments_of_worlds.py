"""What the records of one world say of friction under tables, and edges of sight from its stops."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Edges
from avahazard.criticism.screening.parametric_bootstrap import BootstrapRecords
from avahazard.criticism.screening.record_moments import NOTHING, RecordMoments, record_moments
from avahazard.criticism.screening.tables import LOG_MU, Tables
from avahazard.inference.model.observations import PLACE, Observations

STEEPNESS = 0.5
"""Slope by which a height becomes a distance where places x are recorded."""


def sight_edges(
    tables: Tables, margin: float, measured: BootstrapRecords, observations: Observations
) -> Edges:
    """Edges of sight where stops `margin` (m) above the highest of each path are not seen."""
    limit = estimated_limits(observations, measured, margin)
    nobody = np.zeros(len(limit), dtype=np.bool_)
    silent = tables.speeds._replace(row=np.full(len(limit), -1, dtype=np.int64))
    place = record_moments(
        tables.record,
        tables.bounds,
        tables.last_left,
        np.full(len(limit), np.inf),
        np.full(len(limit), np.nan),
        tables.height,
        np.nan_to_num(limit),
        tables.sigma,
        nobody,
        LOG_MU,
        silent,
        measured.tracks,
        NOTHING,
    )
    known = tables.edges
    declared = np.isfinite(observations.limit)
    estimated = np.isfinite(limit) & ~declared & (observations.columns.path_index >= 0)
    return known._replace(
        seen=np.where(declared, known.seen, place.mean),
        seen_sd=np.where(declared, known.seen_sd, np.sqrt(place.variance)),
        has_limit=np.where(declared, known.has_limit, estimated),
    )


def estimated_limits(
    observations: Observations, measured: BootstrapRecords, margin: float
) -> Floats:
    """Stops from which on nobody looks `[n_events]`: the declared ones, else `margin` (m) above.

    Above the highest stop of the same kind of record on the path; nan where there is none.
    """
    path = observations.columns.path_index
    of_a_path = (path >= 0) & np.isnan(observations.limit)
    limit = observations.limit.copy()
    in_x = observations.kind == PLACE
    for kind, sign in ((in_x, -1.0), (~in_x, 1.0)):
        highest = np.full(len(observations.columns.paths), -np.inf)
        stopped = of_a_path & kind & ~measured.left
        np.maximum.at(highest, path[stopped], sign * measured.observed[stopped])
        known = of_a_path & kind
        known[known] = np.isfinite(highest[path[known]])
        height = margin / (STEEPNESS if sign < 0 else 1.0)
        limit[known] = sign * (highest[path[known]] + height)
    return limit


def moments_of(
    tables: Tables, measured: BootstrapRecords, known: RecordMoments = NOTHING
) -> RecordMoments:
    """RecordMoments of one world under one set of tables.

    They are `known` where these differ by the scatter along tracks alone, but for speeds.
    """
    moments: RecordMoments = record_moments(
        tables.record,
        tables.bounds,
        tables.last_left,
        tables.hidden_from,
        tables.about,
        tables.height,
        measured.observed,
        tables.sigma,
        measured.left,
        LOG_MU,
        tables.speeds,
        measured.tracks,
        known,
    )
    return moments
