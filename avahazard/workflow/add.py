"""A child of a stored model: the same with more effects, calibrated, compared and stored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.scoring.error_budget import with_explained
from avahazard.criticism.scoring.held_out import error_fall
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.fitting.mode import FIRST_SPREAD
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.choices import DEFAULT_METHOD, METHODS
from avahazard.inference.model.observations import build_observations
from avahazard.inference.sampling import N_CHAINS, calibrate_model
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.records.plain import plain
from avahazard.results.base import Report, silent, steps
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison
from avahazard.results.ladder import BeforeAndAfter
from avahazard.store.results import (
    COMPARISON,
    latest_result,
    load_model,
    refuse_taken_name,
    save_result,
)
from avahazard.store.session import reading, writing
from avahazard.workflow.compare import comparison, standing, stored_comparison
from avahazard.workflow.effects import effects_of, read_own_of, stored_text
from avahazard.workflow.next_step import next_step
from avahazard.workflow.stored import (
    calibration_result,
    load_stored,
    require_unchanged,
    save_calibrated,
)


def add(
    database: str,
    name: str,
    effects: Sequence[str],
    new_name: str,
    *,
    effect_files: Sequence[Path] = (),
    report: Report = silent,
) -> Calibration:
    """Add `effects` to the model `name`, calibrate from its mode, compare, store as `new_name`.

    Chains, draws and seed are the parent's. `effect_files` hold the user's own effects, of the
    parent and new ones. Raises `AvahazardError` where a name is taken or unknown, an effect is
    unknown, already there or cannot be told from the data, an effect file is missing or changed, or
    the records have changed since the parent was calibrated.
    """
    with reading(database) as session:
        model = load_model(session, name)
        refuse_taken_name(session, new_name)
        before = stored_comparison(latest_result(session, COMPARISON, name))
    own = read_own_of(model, effect_files)
    definitions = tuple(effect.definition for effect in own.values())
    unused = [key for key in own if key not in (*effects, *effects_of(model))]
    if unused:
        raise AvahazardError(
            f"The effect '{unused[0]}' of the effect file is not asked for.",
            f"Name it: avahazard add {name} {unused[0]} --as {new_name} --effect-file FILE.",
        )
    parent, records = load_stored(database, name, definitions)
    require_unchanged(parent)
    training = only_paths(records, parent.paths)
    observations = build_observations(training)
    specification, new_facts = with_effects(
        observations, parent.specification, effects, definitions
    )
    if specification == parent.specification:
        raise AvahazardError(f"The model {name} has {', '.join(effects)} already.")
    facts = {**parent.facts, **new_facts}
    before_it = parent.calibration
    fresh = before is None and parent.sigma_m is None
    tell = steps(report, (2.0, 1.0, 1.0 if fresh else 0.0))
    found = calibrate_model(
        observations,
        specification,
        facts,
        n_chains=before_it.chains if parent.knows_errors else N_CHAINS,
        n_draws=before_it.draws if parent.knows_errors else METHODS[DEFAULT_METHOD].n_draws,
        seed=before_it.seed,
        own=definitions,
        start=start_from(parent, assemble(observations, specification, facts, definitions)),
        progress=lambda share: tell[0](f"Calibrating {new_name}", share, 1.0),
    )
    result = calibration_result(found, new_name, training, seed=before_it.seed, parent=name)
    after = comparison(new_name, found, lambda share: tell[1](f"Comparing {new_name}", share, 1.0))
    if fresh:
        before = comparison(name, parent, lambda share: tell[2](f"Comparing {name}", share, 1.0))
    after = with_explained(after, before, effects)
    # One transaction: a model that stands without its comparison could not be added again.
    with writing(database) as session:
        text = stored_text(own, specification.effects)
        save_calibrated(session, found, result, paths=parent.paths, effect_file=text)
        if fresh and before is not None:
            save_result(session, COMPARISON, name, plain(before, keyed=True))
        save_result(session, COMPARISON, new_name, plain(after, keyed=True))
    scores = before_and_after(before, after)
    return replace(result, comparison=scores, next=next_step(database, new_name))


def before_and_after(before: Comparison | None, after: Comparison) -> BeforeAndAfter:
    """Scores of parent and child beside the noise floor."""
    floor = after.scores.runout
    return BeforeAndAfter(
        before=None if before is None else standing(before),
        after=standing(after),
        held_out_by=after.held_out.by,
        noise_floor_m=floor.noise_floor_m,
        noise_floor_crps_m=floor.noise_floor_crps_m,
        fall=None if before is None else error_fall(before, after),
        coordinate=after.coordinate,
    )


def start_from(parent: FittedModel, child: Posterior) -> Floats | None:
    """Coordinates to seek the child's mode from: the parent's, its new ones neutral.

    None, to start from the data, where the parent's coordinates mean something else.
    """
    theirs, ours = parent.specification, child.specification
    if (
        not parent.knows_errors
        or theirs.law != ours.law
        or theirs.reference_volume_m3 != ours.reference_volume_m3
    ):
        return None
    slots = [slot.name for slot in parent.layout.slots]
    known = dict(zip(slots, np.median(parent.draws, axis=0), strict=True))
    layout = child.layout
    start = [
        known.get(slot.name, slot.mean if np.isnan(slot.neutral) else slot.neutral)
        for slot in layout.slots
    ]
    for k in layout.spreads.values():
        start[k] = known.get(layout.slots[k].name, FIRST_SPREAD)
    return np.array(start)
