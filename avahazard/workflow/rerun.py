"""A stored calibration done again, from its specification and seed; nothing is stored."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.observations import build_observations
from avahazard.inference.samplers.calibrate import calibrate_model
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.results.base import Report, silent
from avahazard.results.models import Difference, Rerun
from avahazard.workflow.add import start_from
from avahazard.workflow.provenance import show_provenance
from avahazard.workflow.stored.model import load_parameter_draws, load_stored, require_unchanged
from avahazard.workflow.stored.own_effects import own_effects


def rerun(
    database: str,
    name: str,
    *,
    effect_files: Sequence[Path] = (),
    report: Report = silent,
) -> Rerun:
    """Calibrate the model `name` again and hold every draw against the stored ones.

    Raises:
        AvahazardError: there is no such model, its records have changed, or the files of its own
            effects are missing or others.
    """
    own = own_effects(database, name, effect_files)
    stored, records = load_stored(database, name, own)
    require_unchanged(stored)
    kept = load_parameter_draws(database, name)
    if "speed_sigma" in kept:
        raise AvahazardError(
            f"{name} was calibrated with the error of speeds of an earlier version (speed_sigma).",
            "Calibrate a new model: this version knows the scatter of friction along tracks.",
        )
    observations = build_observations(only_paths(records, stored.paths))
    start, told = None, stored.calibration
    if told.parent is not None:
        child = assemble(observations, stored.specification, stored.facts, own)
        start = start_from(load_stored(database, told.parent, own)[0], child)
    found = calibrate_model(
        observations,
        stored.specification,
        stored.facts,
        method=stored.method,
        n_chains=told.chains,
        n_draws=told.draws,
        seed=told.seed,
        own=own,
        start=start,
        progress=lambda share: report(f"Calibrating {name} again", share, 1.0),
    )
    again = dict(zip(found.chains.names, np.moveaxis(found.chains.draws, -1, 0), strict=True))
    differences = {
        key: Difference(
            float(kept[key].mean()),
            float(again[key].mean()),
            float(np.max(np.abs(kept[key] - again[key]))),
        )
        for key in kept
        if not np.array_equal(kept[key], again[key])
    }
    return Rerun(name, not differences, len(kept), differences, _notes(database, name))


def _notes(database: str, name: str) -> tuple[str, ...]:
    """What may make a difference: other versions than at the time."""
    found = show_provenance(database, name)
    if found.made_with is None:
        return ("the versions that the model was made with were not kept.",)
    before, now = found.made_with.versions, found.now.versions
    return tuple(
        f"{package} was {before.get(package, 'not there')}, and is {now[package]} now."
        for package in now
        if before.get(package) != now[package]
    )
