"""What apparent frictions show: their densities, what errors do to them, where F jumps."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.laws import law
from avahazard.inference.model.observations import Observations
from avahazard.inference.paper.apparent import N_REPLICATES, BackCalculation
from avahazard.inference.paper.density import DEFAULT_KAPPA, choose_kappa, holy_density
from avahazard.inference.paper.least_squares import fit_law
from avahazard.physics.runout_curve import MU
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Rows
from avahazard.results.friction import (
    FrictionDensity,
    LargestJump,
    PerturbationCheck,
    PerturbedParameter,
)

Kappa = float | Literal["auto"]

N_POINTS = 201
TAIL = 2.5
"""The density is given this many lengths 1/κ beyond the records: 99 % of its tails."""
LAW = "exponential"
"""The law whose spread under perturbation is told, as in the paper."""


def friction_densities(
    mu: Floats, observations: Observations, kappa: Kappa = DEFAULT_KAPPA
) -> Rows[FrictionDensity]:
    """Holy's density of all events and of each path that has at least two frictions.

    `mu` `[n_events]` are apparent frictions, nan where there is none; `kappa` as in
    `workflow.friction.show_frictions`.
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
            FrictionDensity(
                path_id=name,
                n=int(np.sum(members)),
                kappa=float(density.kappa),
                mu=tuple(x.tolist()),
                pdf=tuple(density.pdf(x).tolist()),
                extrapolated=tuple(density.extrapolated(x).tolist()),
                mean=float(np.mean(mu[members])),
                sd=float(np.std(mu[members], ddof=1)),
            )
        )
    return Rows(densities)


def perturbation_check(found: BackCalculation, observations: Observations) -> PerturbationCheck:
    """What the errors of the records do to the frictions, and to the law fitted to them."""
    sd = found.perturbation.mu_sd[np.isfinite(found.perturbation.mu_sd)]
    volume = np.exp(observations.columns.log_volume)
    check = PerturbationCheck(
        n_replicates=N_REPLICATES,
        n_events=len(sd),
        mu_sd_median=float(np.median(sd)) if len(sd) else None,
        mu_sd_max=float(np.max(sd)) if len(sd) else None,
        law=None,
        parameters={},
    )
    try:
        fit = fit_law(law(LAW), volume, found.mu)
        mean, spread = found.perturbation.law_spread(law(LAW), volume)
    except AvahazardError:  # too few events with a volume for a law
        return check
    figures = np.column_stack([fit.parameters, fit.standard_errors, mean, spread]).tolist()
    parameters = {
        name: PerturbedParameter(*row) for name, row in zip(fit.law.names, figures, strict=True)
    }
    return replace(check, law=LAW, parameters=parameters)


def largest_jumps(
    observations: Observations, predicted: Predicted, found: BackCalculation
) -> Rows[LargestJump]:
    """For each path where F jumps within the frictions of its events, the largest jump.

    A jump is from one friction of the grid to the next.
    """
    jumps = []
    curve = predicted.curve
    steps = np.where(curve.jumps, np.abs(np.diff(curve.y, axis=1)), 0.0)
    for k, name in enumerate(observations.columns.paths):
        mine = np.flatnonzero(observations.columns.path_index == k)
        known = np.concatenate([found.mu_low[mine], found.mu_high[mine]])
        known = known[np.isfinite(known)]
        if not len(known):
            continue
        inside = (MU[1:] > known.min()) & (MU[:-1] < known.max())
        largest = np.max(np.where(inside, steps[mine], 0.0), axis=0)
        at = int(np.argmax(largest))
        if largest[at] > 0.0:
            jumps.append(LargestJump(name, float(MU[at]), float(largest[at])))
    return Rows(jumps)
