"""The loop for the report: the models of the same records, and what the last effect explains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from avahazard.arrays import Bools, Floats
from avahazard.criticism.scoring.scores import crps, expected_records
from avahazard.criticism.scoring.where_it_fails import event_axes
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.report.html.content import LoopView, StateView, SuspectView
from avahazard.report.model_tables import failing
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Diagnosis
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
    comparisons: Mapping[str, Comparison | None],
    diagnoses: Mapping[str, Diagnosis],
) -> LoopView:
    """The model `stored` among those of the ladder that were calibrated on the same records."""
    known = {name: found for name, found in comparisons.items() if found is not None}
    lineage = _lineage(stored.name, models)
    shown: list[StateView] = []
    left_out: dict[str, Note] = {}
    suspect = None
    if stored.sigma_m is None:
        for fit in _others(database, stored, lineage, models, known, left_out):
            shown.append(state_view(fit, known.get(fit.name)))
            if fit.name in lineage[-2:-1]:
                suspect = suspect_view(stored, fit)
    return LoopView(
        models=tuple(shown),
        lineage=lineage,
        comparisons=known,
        diagnoses=diagnoses,
        left_out=left_out,
        suspect=suspect,
    )


def suspect_view(stored: FittedModel, parent: FittedModel) -> SuspectView | None:
    """What the effects that `stored` adds to its parent explain; None where it is no friction."""
    known = {entry.key for entry in parent.definitions}
    added = [entry for entry in stored.definitions if entry.key not in known]
    law, columns = stored.layout.law, stored.columns
    u = np.median(stored.draws, axis=0)
    expected = law.log_friction(u[: len(law.coordinates)], np.exp(columns.log_volume))
    before, after = (
        np.log(apparent_friction(model)[0].mu) - from_reference(model) for model in (parent, stored)
    )
    missed, explained = before - expected, before - after
    there = explained[np.isfinite(explained)]
    if not added or not len(there) or np.ptp(there) < LEAST_EXPLAINED:
        return None
    column = added[0].column if len(added) == 1 else None
    values: Any = {**columns.numbers, **columns.texts}.get(column or "")
    if values is None:
        column = None
    effects = tuple(entry.key for entry in added)
    return SuspectView(effects, missed, explained, column, values)


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
    found: list[FittedModel] = []
    for name in wanted:
        if name == stored.name:
            found.append(stored)
            continue
        if len(found) >= MOST_MODELS:
            left_out[name] = Note("too_many_models", n=MOST_MODELS)
            continue
        try:
            has = next(model.effects for model in models if model.name == name)
            own = tuple(entry for entry in stored.definitions if entry.key in has)
            fit, _ = load_stored(database, name, own=own)
        except AvahazardError:
            left_out[name] = Note("effects_not_given")
            continue
        if (
            fit.calibration.data_fingerprint != stored.calibration.data_fingerprint
            or fit.records_changed
            or fit.paths != stored.paths
        ):
            left_out[name] = Note("other_records")
            continue
        found.append(fit)
    order = {model.name: k for k, model in enumerate(models)}
    return sorted(found, key=lambda fit: order[fit.name])


LEAST_EXPLAINED = 1e-3


def state_view(model: FittedModel, comparison: Comparison | None) -> StateView:
    """What `model` predicts for its records, with the very draws that `compare` scores."""
    expected = expected_records(model, RECORD_DRAWS, generator(0, "compare"))
    return StateView(
        key=model.name,
        predicted=np.quantile(expected.draws, QUANTILES, axis=1).T,
        x=np.quantile(expected.x, QUANTILES, axis=1).T,
        error=expected.error,
        rmse_m=float(np.sqrt(np.mean(expected.error**2))),
        crps_m=float(np.mean(crps(expected.draws, expected.observed))),
        held_out_m=None if comparison is None else comparison.held_out.runout.crps_m,
        failed=_failed(model, expected.x, comparison),
    )


def _failed(model: FittedModel, x: Floats, comparison: Comparison | None) -> Bools:
    """The events of levels where the model fails; `x` `[n_events, n_draws]` are its stops."""
    failed = np.zeros(model.observations.n_events, dtype=np.bool_)
    levels = [] if comparison is None else failing(comparison)
    axes = event_axes(model.observations, np.median(x, axis=1)) if levels else {}
    for row in levels:
        if row.axis in axes:
            failed |= axes[row.axis] == row.level
    return failed
