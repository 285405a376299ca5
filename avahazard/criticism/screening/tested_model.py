"""A model at its mode, and the gains of every candidate on any records of its events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.criticism.screening.alternatives import AtHand, alternatives_of
from avahazard.criticism.screening.gains import Gains
from avahazard.criticism.screening.group_spreads import GroupSpreads
from avahazard.criticism.screening.held_alternatives import HeldAlternatives
from avahazard.criticism.screening.laplace_fit import Design
from avahazard.criticism.screening.masked_pairs import effect_columns
from avahazard.criticism.screening.model_design import base_coordinates, base_design
from avahazard.criticism.screening.tables import make_tables
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.block_runs import run_blocks
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.likelihood.speed_nodes import squares
from avahazard.inference.likelihood.stops_asked import sight_is_limited
from avahazard.physics.runout_curve import RunoutCurve

CURVES = 500
"""Curves that are looked through together."""


@dataclass(frozen=True, slots=True, eq=False)
class TestedModel:
    """A model at its mode `u`, what it predicts, and the gains of every candidate on any records.

    `without` `[n_groupings]` are the designs that grant all groupings but one, `broken`
    `[n_events, n_friction - 1]` the cells over which F jumps, `square` the u² of each track.
    """

    posterior: Posterior
    u: Floats
    spreads: GroupSpreads
    track_scatter: float
    predicted: Predicted
    broken: NDArray[np.bool_]
    square: tuple[Floats, ...]
    gains: Gains
    without: tuple[Design, ...]


def tested_model(
    posterior: Posterior,
    u: Floats,
    spreads: GroupSpreads,
    candidates: Sequence[Definition],
    records_alone: bool,
) -> TestedModel:
    """The model's tables and design, and each candidate spelled out.

    Where the `records_alone` are to be looked at, and no made worlds, blocks that candidates move
    are run near these only.
    """
    observations, layout = posterior.observations, posterior.layout
    near = records_alone and not sight_is_limited(observations, posterior.effects)
    track_scatter = 0.0 if layout.track_scatter is None else float(np.exp(u[layout.track_scatter]))
    values, curvature = layout.effect_values(u), float(posterior.specification.centrifugal)
    runs = run_blocks(observations, posterior.effects, values, curvature)
    predicted = predict_records(observations, posterior.effects, values, curvature, runs)
    design = base_design(posterior, u, spreads.plan, spreads.scale)
    coefficients = base_coordinates(posterior, u)
    about = design.constant + design.x @ coefficients
    base = make_tables(observations, predicted, observations.limit, track_scatter, about)
    spelled = [
        spell
        for entry in candidates
        for spell in alternatives_of(
            entry, posterior, u, base, design, coefficients, track_scatter, runs, near
        )
    ]
    keys = [c.key for c in candidates]
    at_hand = [a for spell in spelled if isinstance(spell, AtHand) for a in spell()]
    columns = effect_columns(base, design, at_hand, {key: k for k, key in enumerate(keys)})
    gains = Gains(
        base,
        design,
        HeldAlternatives(spelled, base),
        keys,
        coefficients,
        float(u[layout.scatter]),
        spreads.tau,
        posterior.specification.tails == "student",
        observations,
        columns,
        any(entry.says_what_is_seen for entry in candidates),
    )
    without = tuple(
        base_design(posterior, u, spreads.plan.without((key,)), np.delete(spreads.scale, g))
        for g, key in enumerate(spreads.plan.keys)
    )
    broken, square = _broken(predicted.curve), tuple(map(squares, predicted.speeds))
    return TestedModel(
        posterior, u, spreads, track_scatter, predicted, broken, square, gains, without
    )


def _broken(curve: RunoutCurve) -> NDArray[np.bool_]:
    """The broken cells of many curves, some at a time: what it takes on the way is large."""
    firsts = range(0, len(curve.x), CURVES)
    return np.concatenate([curve[k : k + CURVES].broken for k in firsts])
