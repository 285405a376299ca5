"""Calibration of a model on the stored records, and its storage."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.catalogue import catalogue, definition, require
from avahazard.effects.effect import Definition, Facts
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import (
    DistributionName,
    LawName,
    MethodName,
    ScatterName,
    Specification,
    TailsName,
)
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.marginal import sample
from avahazard.records.errors import AvahazardError
from avahazard.records.fingerprint import data_fingerprint
from avahazard.store.models import refuse_taken_name
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.calibrated import Calibrated, result_document
from avahazard.workflow.paper_methods import calibrate_paper, check_method
from avahazard.workflow.stored_model import only_paths, save_calibrated

Floats = NDArray[np.float64]

N_CHAINS = 4
N_DRAWS: dict[MethodName, int] = {"marginal": 1000, "metropolis": 5000, "gibbs": 5000}
"""Draws of each chain where the user names none; the marginal method's are nearly independent."""


def calibrate(
    database: str,
    name: str,
    *,
    law: LawName = "exponential",
    scatter: ScatterName = "constant",
    distribution: DistributionName = "lognormal",
    method: MethodName = "marginal",
    tails: TailsName = "normal",
    with_: Sequence[str] = (),
    without: Sequence[str] = (),
    paths: Sequence[str] = (),
    chains: int = N_CHAINS,
    draws: int | None = None,
    seed: int = 0,
    report: Callable[[str, float, float], None] = lambda _what, _done, _total: None,
) -> dict[str, Any]:
    """Calibrate a model on the records (of `paths`, if any are named) and store it as `name`.

    Returns the document of `result_document`. All is stored at the end, or nothing.

    Raises:
        AvahazardError: the name is taken, a path or effect is unknown or cannot be told from
            the data, or the method cannot do it.
    """
    left_out = [definition(key) for key in without]
    keys = _kept_effects(with_, left_out)
    asked = Specification(law=law, scatter=scatter, distribution=distribution, tails=tails)
    for entry in left_out:
        if entry.in_base and entry.changes is not None:
            asked = asked.put(entry.changes, entry.changes.without)
    check_method(method, asked)
    with reading(database) as session:
        refuse_taken_name(session, name)
        records = only_paths(load_records(session), paths)
    observations = build_observations(records)
    for entry in catalogue().values():
        if not entry.in_base and asked.has(entry):
            require(entry, observations.columns, observations.sites)
    specification, facts = with_effects(observations, asked, keys)
    report(f"Calibrating {name}", 0.0, 1.0)
    found = calibrate_study(
        observations,
        specification,
        facts,
        method=method,
        n_chains=chains,
        n_draws=N_DRAWS[method] if draws is None else draws,
        seed=seed,
        progress=lambda share: report(f"Calibrating {name}", share, 1.0),
    )
    fingerprint = data_fingerprint(records)
    document = result_document(found, name, seed=seed, data_fingerprint=fingerprint)
    save_calibrated(database, found, document, paths=tuple(dict.fromkeys(paths)))
    return document


def calibrate_study(
    observations: Observations,
    specification: Specification,
    facts: dict[str, Facts],
    *,
    method: MethodName = "marginal",
    n_chains: int = N_CHAINS,
    n_draws: int = N_DRAWS["marginal"],
    seed: int = 0,
    own: Sequence[Definition] = (),
    start: Floats | None = None,
    progress: Callable[[float], None] = lambda _share: None,
) -> Calibrated:
    """Calibrate a model on observations; nothing is stored.

    `specification` and `facts` are those of `with_effects`, `own` the user's definitions among
    its effects; `start` `[n_slots]` is where the mode is sought from. Raises `AvahazardError`
    where the method cannot do it.
    """
    if method != "marginal":
        return calibrate_paper(
            observations, specification, method, n_chains=n_chains, n_draws=n_draws, seed=seed
        )
    posterior = assemble(observations, specification, facts, own)
    drawn = sample(
        posterior, n_chains=n_chains, n_draws=n_draws, seed=seed, start=start, progress=progress
    )
    model = FittedModel(
        drawn.posterior,
        drawn.coordinates.reshape(-1, drawn.coordinates.shape[2]),
        drawn.offsets_by_path(),
    )
    return Calibrated(model, facts, drawn.chains, observations.n_events)


def _kept_effects(with_: Sequence[str], left_out: Sequence[Definition]) -> list[str]:
    """Effects asked for less those asked away; what the base model has may be in any case."""
    for entry in left_out:
        if not entry.in_base and entry.key not in with_:
            base = [e.key for e in catalogue().values() if e.in_base]
            raise AvahazardError(
                f"The model does not have the effect '{entry.key}'.",
                f"Only {', '.join(base)} is in the base model: --without {base[0]}.",
            )
    away = {entry.key for entry in left_out}
    return [key for key in dict.fromkeys(with_) if key not in away]
