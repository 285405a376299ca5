"""The models of a project: calibrated, compared, diagnosed, and again with what was named."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from avahazard.effects.catalogue import definition
from avahazard.inference.model.given_prior import GIVEN
from avahazard.inference.model.specification import Specification
from avahazard.inference.samplers.calibrate import N_CHAINS
from avahazard.message import counted
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.calibration import Calibration
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.project import Step
from avahazard.store.models import list_models
from avahazard.store.records import load_records
from avahazard.store.results import COMPARISON, DIAGNOSIS, latest_calibration
from avahazard.store.session import reading
from avahazard.workflow.add import add
from avahazard.workflow.calibrate import asked_for, calibrate
from avahazard.workflow.compare import compare
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.project.state import DONE, UP_TO_DATE, ProjectState, stored_result

NAMED = "missing-effect"
"""The verdict on which an effect is added."""


def project_models(run: ProjectState) -> Iterator[tuple[str, Step]]:
    """Calibrate, compare, diagnose, and again with what was named; the last model answers."""
    wanted, skip = run.project, run.project.skip
    model, step = _calibrated(run)
    for round_ in range(wanted.diagnose.rounds + 1):
        yield model, step
        if "compare" not in skip:
            yield model, _compared(run, model)
        if "diagnose" in skip or wanted.model.method != "marginal":
            return
        step, diagnosis = _diagnosed(run, model)
        yield model, step
        if not wanted.diagnose.add or diagnosis.verdict != NAMED:
            return
        if round_ < wanted.diagnose.rounds:
            model, step = _added(run, model, diagnosis.missing)


def _calibrated(run: ProjectState) -> tuple[str, Step]:
    """The model of the file, on the records as they are."""
    wanted = run.project.model
    asked = asked_for(Specification(), [definition(key) for key in wanted.without])

    def fits(stored: Calibration) -> bool:
        return (
            stored.parent is None
            and (stored.law, stored.scatter, stored.distribution, stored.tails)
            == (wanted.law, wanted.scatter, wanted.distribution, wanted.tails)
            and (stored.method, stored.seed) == (wanted.method, wanted.seed)
            and set(stored.effects) == set(wanted.with_) - set(wanted.without)
            and stored.centrifugal == asked.centrifugal
            and _prior_source(stored) == wanted.prior_from
            and {k: [p.mean, p.sd] for k, p in (stored.given_priors or {}).items()} == wanted.prior
            and wanted.chains in (None, stored.chains)
            and wanted.draws in (None, stored.draws)
        )

    known, free = _known(run, wanted.name, wanted.paths, fits)
    if known is not None:
        return known, Step(f"calibrate {known}", UP_TO_DATE, "")
    found = calibrate(
        run.database,
        free,
        law=wanted.law,
        scatter=wanted.scatter,
        distribution=wanted.distribution,
        method=wanted.method,
        tails=wanted.tails,
        with_=wanted.with_,
        without=wanted.without,
        paths=wanted.paths,
        prior_from=wanted.prior_from or None,
        prior=wanted.prior,
        chains=wanted.chains or N_CHAINS,
        draws=wanted.draws,
        seed=wanted.seed,
        report=run.report,
    )
    run.fresh = True
    return free, Step(f"calibrate {free}", DONE, _converged(found))


def _prior_source(stored: Calibration) -> str:
    """The model or paths that the law's prior is from, as `prior_from` names them."""
    source = "" if stored.prior is None else stored.prior.source
    return "" if source.startswith(GIVEN) else source


def _added(run: ProjectState, parent: str, effects: tuple[str, ...]) -> tuple[str, Step]:
    """The child of a model with the effects that its diagnosis named."""

    def fits(stored: Calibration) -> bool:
        return stored.parent == parent and set(effects) <= set(stored.effects)

    name = f"{parent}+{'+'.join(effects)}"
    known, free = _known(run, name, run.project.model.paths, fits)
    if known is not None:
        return known, Step(f"add {known}", UP_TO_DATE, "")
    found = add(run.database, parent, effects, free, report=run.report)
    run.fresh = True
    return free, Step(f"add {free}", DONE, _converged(found))


def _known(
    run: ProjectState, name: str, paths: list[str], fits: Callable[[Calibration], bool]
) -> tuple[str | None, str]:
    """The latest model NAME or NAME-n that fits and stands on today's records, and a free name."""
    with reading(run.database) as session:
        records = only_paths(load_records(session), paths)
        names = [model.name for model in list_models(session)]
        stored = {
            n: Calibration.from_dict(latest_calibration(session, n).result)
            for n in names
            if n == name or n.removeprefix(f"{name}-").isdigit()
        }
    today = data_fingerprint(records)
    right = [n for n, one in stored.items() if one.data_fingerprint == today and fits(one)]
    free, k = name, 2
    while free in names:
        free, k = f"{name}-{k}", k + 1
    return (right[-1] if right else None), free


def _converged(found: Calibration) -> str:
    words = counted(found.n_events, "event")
    return words if found.diagnostics.converged else f"{words}; its chains have NOT converged"


def _compared(run: ProjectState, model: str) -> Step:
    if stored_result(run, COMPARISON, model) is not None:
        return Step(f"compare {model}", UP_TO_DATE, "")
    found = compare(run.database, model, report=run.report)
    run.fresh = True
    error = found.held_out.runout.crps_m
    return Step(f"compare {model}", DONE, f"held-out error (CRPS) {error:.1f} m")


def _diagnosed(run: ProjectState, model: str) -> tuple[Step, Diagnosis]:
    wanted = run.project.diagnose
    document = stored_result(run, DIAGNOSIS, model)
    if document is not None and document["seed"] == wanted.seed:
        found = Diagnosis.from_dict(document)
        return Step(f"diagnose {model}", UP_TO_DATE, _verdict(found)), found
    found = diagnose_model(
        run.database, model, n_worlds=wanted.worlds, seed=wanted.seed, report=run.report
    )
    run.fresh = True
    return Step(f"diagnose {model}", DONE, _verdict(found)), found


def _verdict(found: Diagnosis) -> str:
    if found.cannot_tell:
        return f"{found.verdict}, as far as few data tell"
    return ": ".join([found.verdict, ", ".join(found.missing)]) if found.missing else found.verdict
