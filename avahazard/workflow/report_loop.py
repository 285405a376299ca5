"""The loop for the report: the models of the same records, and what the last effect explains."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.scores import crps, expected_records
from avahazard.criticism.scoring.where_it_fails import event_axes
from avahazard.effects.covariate import number_column
from avahazard.effects.effect import Definition, Effect, FrictionEffect, MotionEffect
from avahazard.effects.motion import FORCE, SPEED, state_at
from avahazard.effects.site import Site
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.cells import GRAVITY, SPEEDS, no_resistance
from avahazard.records.errors import AvahazardError
from avahazard.report.html.content import ForceView, LoopView, StateView, SuspectView
from avahazard.report.model_tables import failing
from avahazard.results.comparison import Comparison, MeasuredForce
from avahazard.results.diagnosis import Diagnosis, Shape
from avahazard.store.results import StoredModel
from avahazard.workflow.compare import RECORD_DRAWS
from avahazard.workflow.friction import apparent_friction, from_reference
from avahazard.workflow.stored import load_stored

MOST_MODELS = 8
QUANTILES = (0.05, 0.5, 0.95)


def loop_view(
    database: str,
    stored: FittedModel,
    models: Sequence[StoredModel],
    comparisons: Mapping[str, Comparison],
    diagnoses: Mapping[str, Diagnosis],
) -> LoopView:
    """The model `stored` among those of the ladder that were calibrated on the same records."""
    lineage = _lineage(stored.name, models)
    shown: list[StateView] = []
    left_out: dict[str, Note] = {}
    suspect = None
    if stored.sigma_m is None:
        for fit in _others(database, stored, lineage, models, comparisons, left_out):
            shown.append(state_view(fit, comparisons.get(fit.name)))
            if fit.name in lineage[-2:-1]:
                suspect = suspect_view(stored, fit, comparisons.get(stored.name))
    return LoopView(tuple(shown), lineage, comparisons, diagnoses, left_out, suspect)


def suspect_view(
    stored: FittedModel, parent: FittedModel, comparison: Comparison | None
) -> SuspectView | None:
    """What the effects that `stored` adds to its parent explain; None where that is nothing.

    `comparison` is that of `stored`, with the measured forces.
    """
    known = {entry.key for entry in parent.definitions}
    added = [entry for entry in stored.definitions if entry.key not in known]
    law, columns = stored.layout.law, stored.columns
    u = np.median(stored.draws, axis=0)
    expected = law.log_friction(u[: len(law.coordinates)], np.exp(columns.log_volume))
    mu = apparent_friction(stored)[0].mu
    before = np.log(apparent_friction(parent)[0].mu) - from_reference(parent)
    after = np.log(mu) - from_reference(stored)
    missed, explained = before - expected, before - after
    band = column = force = None
    values: Any = None
    if len(added) == 1:
        effect = next((e for e in stored.effects if e.key == added[0].key), None)
        if isinstance(effect, FrictionEffect):
            adds = _draws_of(stored, effect) @ effect.design(columns).T
            low, explained, high = np.quantile(adds, QUANTILES, axis=0)
            band, missed = np.stack([low, high]), after - expected + explained
        if isinstance(effect, MotionEffect):
            force = force_view(stored, added[0], effect, comparison, mu)
        column = added[0].column or added[0].reads or ""
        values = number_column(columns, column)
        values = columns.texts.get(column) if values is None else values
    there = explained[np.isfinite(explained)]
    if not added or not len(there) or (np.ptp(there) < LEAST_EXPLAINED and force is None):
        return None
    effects = tuple(entry.key for entry in added)
    column = None if values is None else column
    return SuspectView(effects, missed, explained, band, column, values, force)


def _draws_of(model: FittedModel, effect: Effect) -> Floats:
    """Draws of an effect's parameters `[n_draws, n_parameters]`."""
    place = model.layout.places[effect.key]
    return model.draws[:, place] * [slot.scale for slot in model.layout.slots[place]]


def force_view(
    model: FittedModel,
    entry: Definition,
    effect: MotionEffect,
    comparison: Comparison | None,
    mu: Floats,
) -> ForceView | None:
    """The resistance of an effect over its state; None where that is no one state.

    `mu` `[n_events]` is the apparent friction of the events under the model.
    """
    draws = _draws_of(model, effect)[model.thinned(RECORD_DRAWS)]
    curve = entry.curve(model.facts.get(entry.key, {}))
    if curve is not None:
        of, unit, value, x, on = curve.of, curve.unit, curve.value, curve.x, curve.path
        curves = draws @ curve.columns.T
    else:
        of, unit, value, x, on = SPEED, "m/s", FORCE, SPEEDS[SPEEDS <= MOST_SPEED], None
        found = [force_by_speed(effect, model.observations.sites[0], values) for values in draws]
        if any(one is None for one in found):
            return None
        curves = np.array(found)[:, : len(x)]
    low, middle, high = map(tuple, np.quantile(curves, QUANTILES, axis=0).tolist())
    shape = Shape(of, unit, value, tuple(x.tolist()), low, middle, high, on)
    rows = () if comparison is None else comparison.measured_force or ()
    points = [(row.event_id, *_resisted(model, effect, shape, row, mu)) for row in rows]
    known = [point for point in points if np.isfinite(point[1:]).all()]
    places = np.array([point[1:] for point in known]).reshape(-1, 3)
    return ForceView(shape, [point[0] for point in known], *places.T)


def force_by_speed(effect: MotionEffect, site: Site, values: Floats) -> Floats | None:
    """Force per mass (m/s2) at `SPEEDS`; None where friction or the place matters too."""
    terrain = site.fine_terrain if effect.speed_dependent else site.terrain
    base = no_resistance(terrain)
    found = effect.resistance(site, base, values)
    differs = np.any(found.factor != base.factor) or np.any(found.offset != base.offset)
    differs = differs or np.any(found.speed_factor != 1.0)
    if differs or np.ptp(found.drag) or np.ptp(found.constant):
        return None
    return np.asarray(found.drag[0] * SPEEDS**2 + found.constant[0] + found.speed_constant)


def _resisted(
    model: FittedModel, effect: MotionEffect, shape: Shape, row: MeasuredForce, mu: Floats
) -> tuple[float, float, float]:
    """The state, and what resisted there beyond all but the effect, with its sd."""
    observations = model.observations
    event = observations.columns.event_id.index(row.event_id)
    site = observations.sites[int(observations.columns.path_index[event])]
    if shape.path not in (None, site.path.path_id):
        return np.nan, np.nan, np.nan
    values = model.layout.effect_values(np.median(model.draws, axis=0))
    rest = model.resistance(site, {**values, effect.key: effect.neutral})
    x, u = np.array([row.x_m]), row.speed_m_s
    cell = int(np.searchsorted(site.terrain_for(rest).x, row.x_m, side="right")) - 1
    cell = min(max(cell, 0), len(rest.drag) - 1)
    _, slope, bending = (float(v[0]) for v in site.smooth.derivatives(x))
    cosine = 1.0 / np.sqrt(1.0 + slope**2)
    load = GRAVITY * cosine + rest.curvature * bending * cosine**3 * u**2
    by_speed, more = (
        float(np.interp(u, SPEEDS, table)) for table in (rest.speed_factor, rest.speed_constant)
    )
    friction = rest.factor[cell] * by_speed * mu[event] + rest.offset[cell]
    other = friction * load + rest.constant[cell] + more + rest.drag[cell] * u**2
    per = {FORCE: 1.0, "friction": load}.get(shape.value, u**2)
    at = u if shape.of == SPEED else float(state_at(shape.of, site, x)[0])
    return at, (row.force_m_s2 - other) / per, row.sd_m_s2 / per


def _lineage(name: str, models: Sequence[StoredModel]) -> tuple[str, ...]:
    """The model and its ancestors, the first one first."""
    parents = {model.name: model.parent for model in models}
    line = [name]
    while (parent := parents.get(line[0])) is not None and parent not in line:
        line.insert(0, parent)
    return tuple(line)


def _others(
    database: str,
    stored: FittedModel,
    lineage: Sequence[str],
    models: Sequence[StoredModel],
    known: Mapping[str, Comparison],
    left_out: dict[str, Note],
) -> list[FittedModel]:
    """The models to switch between, oldest first: the lineage, then those of least error."""
    error = {name: found.held_out.runout.crps_m for name, found in known.items()}
    wanted = [name for name in lineage if name in known or name == stored.name]
    wanted += sorted((n for n in error if n not in wanted), key=lambda n: error[n])
    effects = {model.name: model.effects for model in models}
    found = {}
    for name in wanted:
        if name == stored.name:
            found[name] = stored
            continue
        if len(found) >= MOST_MODELS:
            left_out[name] = Note("too_many_models", n=MOST_MODELS)
            continue
        own = tuple(entry for entry in stored.definitions if entry.key in effects[name])
        try:
            fit, _ = load_stored(database, name, own=own)
        except AvahazardError:
            left_out[name] = Note("effects_not_given")
            continue
        same = fit.calibration.data_fingerprint == stored.calibration.data_fingerprint
        if same and not fit.records_changed and fit.paths == stored.paths:
            found[name] = fit
        else:
            left_out[name] = Note("other_records")
    return [found[name] for name in effects if name in found]


LEAST_EXPLAINED = 1e-3
MOST_SPEED = 60.0
"""Of the picture of a force, m/s."""


def state_view(model: FittedModel, comparison: Comparison | None) -> StateView:
    """What `model` predicts for its records, with the very draws that `compare` scores."""
    expected = expected_records(model, RECORD_DRAWS, generator(0, "compare"))
    failed = np.zeros(model.observations.n_events, dtype=np.bool_)
    if comparison is not None and (levels := failing(comparison)):
        axes = event_axes(model.observations, np.median(expected.x, axis=1))
        for row in levels:
            if row.axis in axes:
                failed |= axes[row.axis] == row.level
    return StateView(
        key=model.name,
        predicted=np.quantile(expected.draws, QUANTILES, axis=1).T,
        x=np.quantile(expected.x, QUANTILES, axis=1).T,
        error=expected.error,
        rmse_m=float(np.sqrt(np.mean(expected.error**2))),
        crps_m=float(np.mean(crps(expected.draws, expected.observed))),
        held_out_m=None if comparison is None else comparison.held_out.runout.crps_m,
        failed=failed,
    )
