"""The loop for the report: the models of the same records, and the effects that can be moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from avahazard.effects.effect import Definition
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.report.html.content import LoopView, StateView, SweepView
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Diagnosis
from avahazard.store.models import StoredModel
from avahazard.workflow.report_states import FRICTION, places, state_view, to_come, volumes_of
from avahazard.workflow.report_strength import sweep, sweepable
from avahazard.workflow.stored.model import load_stored
from avahazard.workflow.stored.own_effects import effects_of

MOST_MODELS, MOST_SWEEPS = 8, 2


def loop_view(
    database: str,
    stored: FittedModel,
    records: Records,
    models: Sequence[StoredModel],
    comparisons: Mapping[str, Comparison | None],
    diagnoses: Mapping[str, Diagnosis],
) -> LoopView:
    """The model `stored` among those of the ladder that were calibrated on the same records.

    `records` are all of the database.
    """
    known = {name: found for name, found in comparisons.items() if found is not None}
    lineage = _lineage(stored.name, models)
    volumes = volumes_of(stored.columns)
    paths = tuple(site.path.path_id for site in stored.observations.sites)
    shown: list[StateView] = []
    swept: list[StateView] = []
    sweeps: list[SweepView] = []
    left_out: dict[str, Note] = {}
    if stored.sigma_m is None:
        future = [to_come(records, path_id, volumes) for path_id in paths]
        for fit in _others(database, stored, lineage, models, known, left_out):
            shown.append(state_view(fit.name, fit, future, known.get(fit.name)))
        own = next(state for state in shown if state.key == stored.name)
        for effect in _movable(stored, models):
            keys, strengths = [], []
            for strength, model in sweep(stored, effect):
                key = f"{effect} × {strength:g}"
                if strength == 1.0:
                    key = own.key
                else:
                    swept.append(state_view(key, model, future, None))
                keys.append(key)
                strengths.append(strength)
            sweeps.append(SweepView(effect, tuple(strengths), tuple(keys)))
    trees = [entry.key for entry in stored.definitions if entry.trees]
    return LoopView(
        models=tuple(shown),
        swept=tuple(swept),
        sweeps=tuple(sweeps),
        places=tuple(places(stored, trees)),
        lineage=lineage,
        comparisons=known,
        diagnoses=diagnoses,
        left_out=left_out,
        volumes=volumes,
        mu=FRICTION,
    )


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
            fit, _ = load_stored(database, name, _own_of(name, stored.definitions, models))
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


def _own_of(
    name: str, own: Sequence[Definition], models: Sequence[StoredModel]
) -> tuple[Definition, ...]:
    """Those of these effects that a model has."""
    has = next(effects_of(model) for model in models if model.name == name)
    return tuple(entry for entry in own if entry.key in has)


def _movable(stored: FittedModel, models: Sequence[StoredModel]) -> list[str]:
    """Effects to move, what was added last first."""
    parent = next((m for m in models if m.name == stored.calibration.parent), None)
    before = () if parent is None else effects_of(parent)
    keys = sweepable(stored)
    return sorted(keys, key=lambda key: key in before)[:MOST_SWEEPS]
