"""Which physical effect a stored model lacks, if any: verdict, candidates, what to measure next."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.criticism.diagnosis.laws import FoundLaw
from avahazard.criticism.screening.screen import candidate_definitions
from avahazard.effects.catalogue import require
from avahazard.effects.effect import Definition
from avahazard.effects.pairs import other_way
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import LEFT
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.report.model_tables import failing, failing_speeds
from avahazard.report.picture import require_picture
from avahazard.results import diagnosis as results
from avahazard.results.base import Report, Rows, plain, silent
from avahazard.results.comparison import Comparison
from avahazard.store import results as store
from avahazard.store.session import reading, require_writable, writing
from avahazard.workflow.compare import coordinate_name
from avahazard.workflow.effects import read_own_of, write_effect_file
from avahazard.workflow.next_step import latest_comparison, latest_diagnosis, next_step
from avahazard.workflow.requests import DiagnoseRequest
from avahazard.workflow.stored import load_stored, notes_of_fit, require_unchanged

MOST_PATHS = 4


def diagnose_model(
    database: str, name: str, request: DiagnoseRequest, report: Report = silent
) -> results.Diagnosis:
    """Diagnose the stored model `name`, and store it; effects of `effect_files` are candidates too.

    A law is written by the last diagnosis where that was asked the same. Raises `AvahazardError`
    where there is no such model, an expected effect is no candidate, its records have changed, none
    stopped on its profile, or its method cannot test effects.
    """
    plot, file = request.plot, request.write_effect
    if file is not None and file.exists():
        raise AvahazardError(f"{file} is there already.", "Name another file.")
    require_picture(plot)
    require_writable(database)
    with reading(database) as session:
        own = tuple(read_own_of(store.load_model(session, name), request.effect_files).values())
    stored, _ = load_stored(database, name, own=own)
    if not stored.knows_errors:
        raise AvahazardError(
            f"The model {name} was calibrated by {stored.method}, which cannot test effects.",
            "Calibrate one with --method marginal.",
        )
    require_unchanged(stored)
    if (stored.observations.kind == LEFT).all():
        raise AvahazardError(
            f"Every event of {name} ran beyond its profile: no effect could show in them.",
            "Import events whose runout was recorded, or profiles that reach beyond the stops; "
            'a project goes on without: skip = ["diagnose"] in avahazard.toml.',
        )
    asked = replace(request, plot=None, write_effect=None)
    told = _known(database, name, asked) if file is not None else None
    told = told or _diagnosed(database, stored, own, asked, report)
    if own:
        keys = (entry.key for entry in own)
        files = dict(zip(keys, map(str, request.effect_files), strict=True))
        told = replace(told, given_files=files)
    if file is not None and told.law_text is not None:
        write_effect_file(file, told.law_text)
        told = replace(told, effect_file=str(file))
    with writing(database) as session:
        store.save_result(session, store.DIAGNOSIS, name, plain(told, keyed=True))
    if file is not None and told.law_text is None:
        raise _no_law(file, told)
    if plot is not None:
        told.plot(plot)
    return replace(told, next=next_step(database, name))


def _known(database: str, name: str, asked: DiagnoseRequest) -> results.Diagnosis | None:
    """The last diagnosis of a model where that was asked the same, and has any law as a file."""
    with reading(database) as session:
        last = latest_diagnosis(session, name)
    if last is None or last.declared or asked != DiagnoseRequest(seed=last.seed):
        return None
    return last if last.law_text or not last.lawful else None


def _diagnosed(
    database: str,
    stored: FittedModel,
    own: Sequence[Definition],
    request: DiagnoseRequest,
    report: Report,
) -> results.Diagnosis:
    name, expect = stored.name, check_expected(stored, request.expect, own)
    found = diagnose(
        stored.observations,
        stored.specification,
        stored.facts,
        own,
        expected=expect,
        field_days=results.FIELD_DAYS | dict(request.field_days),
        seed=request.seed,
        calibrated=np.median(stored.draws, axis=0),
        progress=partial(report, f"Diagnosing {name}"),
    )
    told = found.result
    # What is missing may be what the paths differ by.
    of_fit = [n for n in notes_of_fit(stored) if not (told.missing and n.key == "paths_differ")]
    told = replace(
        told,
        model=name,
        coordinate=coordinate_name(stored.observations),
        notes=(*of_fit, *told.notes),
        where=_where(database, stored, told, own),
    )
    if expect:
        at = store.now().isoformat(timespec="seconds")
        told = replace(told, declared=results.Declared(expect, f"{at}Z"))
    if found.laws:
        told = replace(told, law_text=_law_file(stored, told, found.laws[0], request.seed))
    return told


def _law_file(stored: FittedModel, told: results.Diagnosis, law: FoundLaw, seed: int) -> str:
    """The effect file of a law, with where it comes from."""
    record, lawful = stored.calibration.data_fingerprint, told.lawful
    assert lawful is not None
    laws = lawful.laws or Rows()
    lines = [
        f"The leading law of {lawful.effect}, found by `avahazard diagnose {stored.name}`.",
        "",
        f"On {stored.observations.n_events} events (data fingerprint {record}), seed {seed}.",
        "Evidence over the model without it (nats), of all laws within 3 nats of the first:",
        *(f"- {one.form}, {one.formula}: {one.evidence:.1f}" for one in laws),
        "Parameters of the first (median, 90 % credible interval):",
        *(
            f"- {name}: {p.q50:.3g} ({p.q05:.3g} to {p.q95:.3g}) {p.unit}".rstrip()
            for name, p in laws[0].parameters.items()
        ),
        "The priors below were those of this fit. Constants in capitals are not fitted again.",
    ]
    return '"""' + "\n".join(lines) + f'\n"""\n\n{law.text}'


def _no_law(file: Path, told: results.Diagnosis) -> AvahazardError:
    if not told.missing:
        return AvahazardError(
            f"{file} is not written: these data show no effect that {told.model} lacks.",
            "The diagnosis is stored; without --write-effect it is shown.",
        )
    return AvahazardError(
        f"{file} is not written: what {told.model} lacks first is {told.missing[0]}, which is no "
        "smooth curve.",
        "Follow the next step of `avahazard diagnose`; an effect of the catalogue needs no file.",
    )


def check_expected(
    stored: FittedModel, expect: Sequence[str], own: Sequence[Definition]
) -> tuple[str, ...]:
    """The expected effects by the keys that they have as candidates: a pair is one either way.

    Raises `AvahazardError` for one that is no candidate, with the reason.
    """
    observations = stored.observations
    known = {c.key for c in candidate_definitions(observations, stored.specification, own)}
    either_way = {key: one for one in known for key in (one, other_way(one))}
    for key in expect:
        entry = find_definition(key, own)
        if key in either_way:
            continue
        if stored.specification.has(entry):
            raise AvahazardError(f"The model {stored.name} has the effect '{key}' already.")
        require(entry, observations.columns, observations.sites)
        raise AvahazardError(
            f"The effect '{key}' is no candidate here: it is granted, or set by the data.",
            "`avahazard effects` lists them.",
        )
    return tuple(either_way[key] for key in expect)


def _where(
    database: str, stored: FittedModel, found: results.Diagnosis, own: Sequence[Definition]
) -> tuple[Note, ...]:
    """On which paths the model fails, if it was compared, and where is what it lacks."""
    observations = stored.observations
    with reading(database) as session:
        compared = latest_comparison(session, stored.name)
    if not found.missing:
        return tuple(unexplained_failures(compared)) if compared else ()
    notes = failing_paths(compared) if compared else []
    tried = {c.effect for c in found.candidates}
    for key in found.missing:
        if key in tried and (
            seen := find_definition(key, own).seen_in(observations.columns, observations.sites)
        ):
            notes.append(Note.read(seen))
    return tuple(notes)


def unexplained_failures(compared: Comparison) -> list[Note]:
    """A note where an adequate model fails beyond chance all the same; or none."""
    fails = failing(compared) or failing_speeds(compared)
    return [Note("fails_unexplained")] if fails else []


def failing_paths(compared: Comparison) -> list[Note]:
    """A note on the paths on which a model fails beyond chance, and which way; or none."""
    paths = [row for row in failing(compared) if row.axis == "path"]
    shown = [Note("path_bias", path=row.level, bias=row.bias_m) for row in paths[:MOST_PATHS]]
    return [Note("fails_on", paths=shown)] if shown else []
