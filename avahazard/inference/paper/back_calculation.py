"""Apparent friction of recorded events, and what the records' errors do to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, Observations
from avahazard.inference.paper.apparent import UNIQUE, apparent_friction
from avahazard.inference.paper.perturbation import Perturbation, perturb
from avahazard.inference.seeds import generator
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_curve import MU

SEED = 0
"""The perturbation is the same each time that the records are."""
N_REPLICATES = 200


@dataclass(frozen=True, slots=True, eq=False)
class BackCalculation:
    """Apparent friction `mu` and its `status` (`apparent.STATUSES`), each `[n_events]`.

    `mu_low`, `mu_high` bracket it; `perturbation` holds replicates of the moved records.
    """

    mu: Floats
    mu_low: Floats
    mu_high: Floats
    status: NDArray[np.int64]
    perturbation: Perturbation


def back_calculate(observations: Observations, predicted: Predicted) -> BackCalculation:
    """Invert F at every record, and again at `N_REPLICATES` sets of records moved by their errors.

    `predicted` is that of the model without effects. Without a profile μ = H/L.
    """
    straight = observations.kind == LENGTH
    # A place x falls with friction, where elevations rise.
    sign = np.where(observations.kind == ELEVATION, 1.0, -1.0)
    sign[observations.kind == LEFT] = 1.0
    records = np.where(observations.kind == LEFT, -np.inf, sign * observations.observed)
    rows = np.flatnonzero(~straight)
    tables = (
        np.arange(len(rows)),
        sign[rows, None] * predicted.record[rows],
        predicted.curve[rows],
    )
    mu = observations.fall_height / observations.observed
    low, high, status = mu.copy(), mu.copy(), np.full(observations.n_events, UNIQUE)
    moved = np.full((N_REPLICATES, observations.n_events), np.nan)
    sd = np.full(observations.n_events, np.nan)
    if len(rows):
        inverse = apparent_friction(records[rows], *tables)
        mu[rows], low[rows] = inverse.mu, inverse.mu_low
        # Where no friction stops the block on the profile, one that held it is too high.
        high[rows] = np.minimum(inverse.mu_high, _held_from(predicted.status[rows]))
        status[rows] = inverse.status
        spread = perturb(
            records[rows], observations.sigma[rows], *tables, seed=SEED, n_replicates=N_REPLICATES
        )
        moved[:, rows], sd[rows] = spread.mu, spread.mu_sd
    if np.any(straight):
        moved[:, straight] = _perturb_straight(observations, straight)
        sd[straight] = np.nanstd(moved[:, straight], axis=0, ddof=1)
    return BackCalculation(mu, low, high, status, Perturbation(moved, sd))


def _held_from(status: NDArray[np.int8]) -> Floats:
    """Lowest friction of the grid that held the block at its release, `[n_events]`; else ∞."""
    held = status == NOT_RELEASED
    return np.where(held.any(axis=1), MU[held.argmax(axis=1)], np.inf)


def _perturb_straight(observations: Observations, straight: NDArray[np.bool_]) -> Floats:
    """H/L of moved lengths, `[N_REPLICATES, n_straight]`; nan where a length fell below zero."""
    noise = generator(SEED, "perturbation", "straight").standard_normal(
        (N_REPLICATES, int(np.sum(straight)))
    )
    length = observations.observed[straight] + observations.sigma[straight] * noise
    return np.where(length > 0.0, observations.fall_height[straight] / length, np.nan)
