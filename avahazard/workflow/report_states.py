"""What the models of the ladder predict for the same records, for the switch of the report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.scoring.expected import expected_records
from avahazard.criticism.scoring.scores import crps
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Effect, MotionEffect, of_kind
from avahazard.hazard.future_events import FutureEvents, classes_of
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.resistance import Resistance
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.lookup import of_path
from avahazard.report.html.content import PlaceView, StateView
from avahazard.results.comparison import Comparison

RECORD_DRAWS = 1000
QUANTILES = (0.05, 0.5, 0.95)
FRICTION = MU[(MU > 0.0999) & (MU < 0.9001)][::2]
"""Frictions of the tables in the page `[n_friction]`."""
N_VOLUMES = 24
NOTHING: Floats = np.empty((0, 0))
LEAST_LENGTH_M = 1.0


def volumes_of(columns: EventColumns) -> Floats:
    """Volumes (m3) over the recorded ones `[n_volumes]`; none where none is recorded."""
    log_volume = columns.log_volume
    known = log_volume[np.isfinite(log_volume)]
    if not len(known):
        return np.empty(0)
    return np.geomspace(np.exp(known.min()), np.exp(known.max()), N_VOLUMES)


def to_come(records: Records, path_id: str, volumes: Floats) -> FutureEvents:
    """An avalanche of each volume (m3) on a path; of any volume where there is none."""
    sizes = volumes.tolist() or [1e4]
    events = tuple(Event("", path_id=path_id, volume_m3=size) for size in sizes)
    return classes_of(replace(of_path(records, path_id), events=events))


def state_view(
    key: str,
    model: FittedModel,
    future: Sequence[FutureEvents],
    comparison: Comparison | None,
) -> StateView:
    """What `model` predicts for its records, with the very draws that `compare` scores.

    `future` are the avalanches of `to_come` of each path, on whose sites the block is run.
    """
    expected = expected_records(model, RECORD_DRAWS, generator(0, "compare"))
    paths, stops, friction = _blocks(model, future) if future else ((), NOTHING, NOTHING)
    return StateView(
        key=key,
        predicted=np.quantile(expected.draws, QUANTILES, axis=1).T,
        x=np.quantile(expected.x, QUANTILES, axis=1).T,
        error=expected.error,
        rmse_m=float(np.sqrt(np.mean(expected.error**2))),
        crps_m=float(np.mean(crps(expected.draws, expected.observed))),
        held_out_m=None if comparison is None else comparison.held_out.runout.crps_m,
        path_ids=paths,
        stops=stops,
        friction=friction,
    )


def _blocks(
    model: FittedModel, future: Sequence[FutureEvents]
) -> tuple[tuple[str, ...], Floats, Floats]:
    """Paths, F(μ) `[n_paths, n_friction]` and median friction `[n_paths, n_volumes]`."""
    u = np.median(model.draws, axis=0)
    values = model.layout.effect_values(u)
    paths, stops, friction = [], [], []
    for there in future:
        site, path_id = there.site, there.site.path.path_id
        curve = site.table(site.cells(model.resistance(site, values)))[0]
        x = np.where(curve.status == LEFT_PROFILE, np.inf, curve.x)
        paths.append(path_id)
        stops.append(x[np.searchsorted(MU, FRICTION - 1e-9)])
        volume = np.exp(there.columns.log_volume)[:, None]
        events = model.friction.of_events(there.columns)
        location = model.friction.location_and_scatter(u, volume, events)[0][:, 0]
        offset = model.offsets.get(path_id)
        shift = 0.0 if offset is None else float(np.median(offset))
        in_log = location if model.layout.log_scatter else np.log(location)
        friction.append(np.exp(in_log + shift))
    return tuple(paths), np.array(stops), np.array(friction)


def places(model: FittedModel, trees: Sequence[str]) -> Iterator[PlaceView]:
    """Where on each path an effect on the motion acts, if not all along it.

    `trees` are the effects that are drawn as trees.
    """
    values = model.layout.effect_values(np.median(model.draws, axis=0))
    for effect in of_kind(model.effects, MotionEffect):
        for site in model.observations.sites:
            alone = model.resistance(site, _alone(model.effects, effect, values))
            none = model.resistance(site, _alone(model.effects, None, values))
            terrain = site.terrain_for(alone)
            acts = _differ(alone, none)
            if acts is None or acts.all() or not acts.any():
                continue
            edges = np.flatnonzero(np.diff(np.concatenate([[False], acts, [False]])))
            stretches = [
                (float(terrain.x[a]), float(terrain.x[b]))
                for a, b in edges.reshape(-1, 2)
                if terrain.x[b] - terrain.x[a] > LEAST_LENGTH_M
            ]
            path_id = site.path.path_id
            yield PlaceView(effect.key, path_id, tuple(stretches), effect.key in trees)


def _alone(
    effects: Sequence[Effect], effect: Effect | None, values: dict[str, Floats]
) -> dict[str, Floats]:
    """The values with all effects but one at neutral."""
    return {e.key: values.get(e.key, e.neutral) if e is effect else e.neutral for e in effects}


def _differ(one: Resistance, other: Resistance) -> NDArray[np.bool_] | None:
    """Cells `[n_cells]` in which two resistances differ; None where it is so everywhere."""
    if len(one.drag) != len(other.drag) or one.curvature != other.curvature:
        return None
    return np.asarray(
        (one.factor != other.factor)
        | (one.offset != other.offset)
        | (one.constant != other.constant)
        | (one.drag != other.drag)
    )
