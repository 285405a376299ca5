"""Apparent friction of the recorded events, its density, and what the records' errors do to it.

These are the paper's views of the records, for people. Calibration does not use them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.laws import law
from avahazard.inference.model.observations import (
    ELEVATION,
    LEFT,
    LENGTH,
    Observations,
    build_observations,
)
from avahazard.inference.paper.apparent import STATUSES, UNIQUE, apparent_friction, jump_size
from avahazard.inference.paper.density import DEFAULT_KAPPA, choose_kappa, holy_density
from avahazard.inference.paper.least_squares import fit_law
from avahazard.inference.paper.perturbation import Perturbation, perturb
from avahazard.inference.seeds import generator
from avahazard.physics.block import NOT_RELEASED, STOPPED
from avahazard.physics.runout_table import MU, MU_STEP
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.one_path import find_path

Floats = NDArray[np.float64]
Kappa = float | Literal["auto"]

SEED = 0
"""The perturbation is the same each time that the records are."""
N_REPLICATES = 200
N_POINTS = 201
TAIL = 2.5
"""The density is given this many lengths 1/κ beyond the records: 99 % of its tails."""
LAW = "exponential"
"""The law whose spread under perturbation is told, as in the paper."""


@dataclass(frozen=True, slots=True, eq=False)
class Frictions:
    """Apparent friction `mu` and its `status` (`apparent.STATUSES`), each `[n_events]`.

    `mu_low`, `mu_high` bracket it; `perturbation` holds replicates of the moved records.
    """

    mu: Floats
    mu_low: Floats
    mu_high: Floats
    status: NDArray[np.int64]
    perturbation: Perturbation


def show_frictions(
    database: str,
    path_id: str | None = None,
    kappa: Kappa = DEFAULT_KAPPA,
    plot: FilePath | None = None,
) -> dict[str, Any]:
    """Return the apparent friction of every event, of one path or all (docs/results.md).

    `kappa` "auto" takes, for each density, that with the best held-out likelihood. With
    `plot` a picture of the densities is written there.

    Raises:
        AvahazardError: the database or the path is missing, there are no events, a path of
            theirs has no profile, or `plot` is not the name of a picture.
    """
    with reading(database) as session:
        records = load_records(session)
    if path_id is not None:
        find_path(records, path_id)
        mine = tuple(event for event in records.events if event.path_id == path_id)
        if not mine:
            raise AvahazardError(
                f"Path {path_id} has no events.", "Import some: avahazard import FOLDER."
            )
        records = Records(records.paths, records.profiles, mine, records.speeds)
    observations = build_observations(records)
    predicted = predict_records(observations, (), {})
    found = back_calculate(observations, predicted)
    names = [
        observations.columns.paths[k] if k >= 0 else None for k in observations.columns.path_index
    ]
    document: dict[str, Any] = {
        "events": [
            {
                "event_id": observations.columns.event_id[i],
                "path_id": names[i],
                "mu": found.mu[i],
                "mu_sd": found.perturbation.mu_sd[i],
                "status": STATUSES[found.status[i]],
                "mu_low": found.mu_low[i],
                "mu_high": found.mu_high[i],
            }
            for i in range(observations.n_events)
        ],
        "density": friction_densities(found.mu, observations, kappa),
        "perturbation": _perturbation(found, observations),
        "jumps": _jumps(observations, predicted, found),
    }
    if plot is not None:
        from avahazard.report.friction_figure import draw_densities  # noqa: PLC0415 (slow)

        draw_densities(plot, document["density"])
    return document


def back_calculate(observations: Observations, predicted: Predicted) -> Frictions:
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
        predicted.status[rows].astype(np.int64),
        float(MU[0]),
        MU_STEP,
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
    return Frictions(mu, low, high, status, Perturbation(moved, sd))


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


def friction_densities(
    mu: Floats, observations: Observations, kappa: Kappa = DEFAULT_KAPPA
) -> list[dict[str, Any]]:
    """Holy's density of all events and of each path that has at least two frictions.

    `mu` `[n_events]` are apparent frictions, nan where there is none; `kappa` as in
    `show_frictions`.
    """
    groups = {"all": np.isfinite(mu)} | {
        name: np.isfinite(mu) & (observations.columns.path_index == k)
        for k, name in enumerate(observations.columns.paths)
    }
    densities = []
    for name, members in groups.items():
        if np.sum(members) < 2:
            continue
        width = choose_kappa(mu[members]) if kappa == "auto" else kappa
        density = holy_density(mu[members], width)
        x = np.linspace(density.mu[0] - TAIL / width, density.mu[-1] + TAIL / width, N_POINTS)
        densities.append(
            {
                "path_id": name,
                "n": int(np.sum(members)),
                "kappa": density.kappa,
                "mu": x,
                "pdf": density.pdf(x),
                "extrapolated": density.extrapolated(x),
            }
        )
    return densities


def _perturbation(found: Frictions, observations: Observations) -> dict[str, Any]:
    """What the errors of the records do to the frictions, and to the law fitted to them."""
    sd = found.perturbation.mu_sd[np.isfinite(found.perturbation.mu_sd)]
    volume = np.exp(observations.columns.log_volume)
    document: dict[str, Any] = {
        "n_replicates": N_REPLICATES,
        "n_events": len(sd),
        "mu_sd_median": float(np.median(sd)) if len(sd) else None,
        "mu_sd_max": float(np.max(sd)) if len(sd) else None,
        "law": None,
        "parameters": {},
    }
    try:
        fit = fit_law(law(LAW), volume, found.mu)
        mean, spread = found.perturbation.law_spread(law(LAW), volume)
    except AvahazardError:  # too few events with a volume for a law
        return document
    parameters = zip(fit.law.names, fit.parameters, fit.standard_errors, mean, spread, strict=True)
    document["law"] = LAW
    document["parameters"] = {
        name: {"value": value, "se": se, "mean": centre, "sd": width}
        for name, value, se, centre, width in parameters
    }
    return document


def _jumps(
    observations: Observations, predicted: Predicted, found: Frictions
) -> list[dict[str, Any]]:
    """For each path where F jumps within the frictions of its events, the largest jump.

    A jump is from one friction of the grid to the next.
    """
    jumps = []
    for k, name in enumerate(observations.columns.paths):
        mine = np.flatnonzero(observations.columns.path_index == k)
        known = np.concatenate([found.mu_low[mine], found.mu_high[mine]])
        known = known[np.isfinite(known)]
        if not len(known):
            continue
        inside = (MU[1:] > known.min()) & (MU[:-1] < known.max())
        largest, at = 0.0, 0
        for i in mine:
            stopped = predicted.status[i] == STOPPED
            y = predicted.elevation[i]
            steps = np.where(inside & stopped[1:] & stopped[:-1], np.abs(np.diff(y)), 0.0)
            j = int(np.argmax(steps))
            if steps[j] >= jump_size(y, stopped) and steps[j] > largest:
                largest, at = float(steps[j]), j
        if largest > 0.0:
            jumps.append({"path_id": name, "mu": float(MU[at]), "jump_m": largest})
    return jumps
