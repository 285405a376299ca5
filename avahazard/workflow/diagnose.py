"""Which physical effect a stored model lacks, if any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.findings import Diagnosis as Findings
from avahazard.criticism.screening.candidates import candidate_definitions
from avahazard.effects.catalogue import require
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import LEFT
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.message import message, named
from avahazard.records.errors import AvahazardError
from avahazard.report.picture import require_picture
from avahazard.results.base import Report, silent
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import (
    Declared,
    Diagnosis,
)
from avahazard.store.models import load_model, now
from avahazard.store.results import COMPARISON, DIAGNOSIS, latest_result, save_result
from avahazard.store.session import reading, writing
from avahazard.workflow.compare import stored_comparison
from avahazard.workflow.requests import DiagnoseRequest
from avahazard.workflow.stored.diagnosis import diagnosis
from avahazard.workflow.stored.model import load_stored, require_unchanged
from avahazard.workflow.stored.notes import notes_of_fit
from avahazard.workflow.stored.own_effects import read_own_of

CHANCE, MOST_PATHS = 0.05, 4

FAILS_ON = message("It fails beyond chance on {paths}; predicted less recorded.")


def diagnose_model(
    database: str,
    name: str,
    request: DiagnoseRequest,
    report: Report = silent,
) -> Diagnosis:
    """Diagnose the stored model `name`, and store it; effects of `effect_files` are candidates too.

    Raises:
        AvahazardError: there is no such model, it has an expected effect already or the data
            cannot tell it, its records have changed, none of them stopped on its profile, or its
            method has no likelihood that effects could be tested in.
    """
    expect, plot = request.expect, request.plot
    require_picture(plot)
    with reading(database) as session:
        own_files = read_own_of(load_model(session, name), request.effect_files)
    own = tuple(effect.definition for effect in own_files.values())
    stored, _ = load_stored(database, name, own)
    if not stored.knows_errors:
        raise AvahazardError(
            f"The model {name} was calibrated by {stored.method}, which cannot test effects.",
            "Calibrate one with --method marginal.",
        )
    require_unchanged(stored)
    _require_stops(stored)
    check_expected(stored, expect, own)
    found = diagnose(
        stored.observations,
        stored.specification,
        stored.facts,
        own,
        expected=tuple(expect),
        n_worlds=request.worlds,
        seed=request.seed,
        progress=lambda share: report(f"Diagnosing {name}", share, 1.0),
    )
    told = diagnosis(name, found, request.seed)
    told = replace(told, notes=(*notes_of_fit(stored), *told.notes))
    told = replace(told, where=_where(database, stored, found, own))
    if expect:
        at = now().isoformat(timespec="seconds")
        told = replace(told, declared=Declared(tuple(expect), f"{at}Z"))
    with writing(database) as session:
        save_result(session, DIAGNOSIS, name, told.to_dict())
    if plot is not None:
        from avahazard.report.diagnosis_figure import draw_diagnosis  # noqa: PLC0415 (slow)

        draw_diagnosis(plot, told)
    return told


def _require_stops(stored: FittedModel) -> None:
    """Raise `AvahazardError` where all events left: whatever shifts their friction is unseen."""
    if (stored.observations.kind == LEFT).all():
        raise AvahazardError(
            f"Every event of {stored.name} left its profile: no effect could be seen in them.",
            "Import events whose runout was recorded, or profiles that reach beyond the stops; "
            'a project goes on without: skip = ["diagnose"] in avahazard.toml.',
        )


def check_expected(stored: FittedModel, expect: Sequence[str], own: Sequence[Definition]) -> None:
    """Raise `AvahazardError` for an expected effect that is no candidate, with the reason."""
    observations = stored.observations
    known = {c.key for c in candidate_definitions(observations, stored.specification, own)}
    for key in expect:
        entry = find_definition(key, own)
        if key in known:
            continue
        if stored.specification.has(entry):
            raise AvahazardError(f"The model {stored.name} has the effect '{key}' already.")
        require(entry, observations.columns, observations.sites)
        raise AvahazardError(
            f"The effect '{key}' is no candidate here: it is granted, or told by the data.",
            "`avahazard effects` lists them.",
        )


def _where(
    database: str, stored: FittedModel, found: Findings, own: Sequence[Definition]
) -> tuple[str, ...]:
    """On which paths the model fails, if it was compared, and where is what it lacks."""
    if not found.missing:
        return ()
    observations = stored.observations
    with reading(database) as session:
        compared = stored_comparison(latest_result(session, COMPARISON, stored.name))
    words = [] if compared is None else failing_paths(compared)
    tried = {c.key for c in found.candidates}
    for key in found.missing:
        if key in tried:
            seen = find_definition(key, own).seen_in(observations.columns, observations.sites)
            words += [seen] if seen else []
    return tuple(words)


def failing_paths(compared: Comparison) -> list[str]:
    """The paths on which a model fails beyond chance, and which way, in a sentence; or none."""
    paths = [row for row in compared.where_it_fails if row.axis == "path" and row.p_value < CHANCE]
    if not paths:
        return []
    shown = [f"{row.level} ({row.bias_m:+.0f} m)" for row in paths[:MOST_PATHS]]
    return [FAILS_ON.format(paths=named(shown))]
