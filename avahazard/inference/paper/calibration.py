"""The paper's own samplers on observations: Metropolis-Hastings (2c) and Gibbs (2d).

Both use the stops as recorded and the volumes as exact, and no measured speeds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.fitted_model import Chains, FittedModel, fitted_model, in_slots
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.laws import Law, law
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.gibbs import gibbs
from avahazard.inference.paper.metropolis import metropolis
from avahazard.notes import Note
from avahazard.physics.runout_curve import EVEN, MU, MU_STEP
from avahazard.records.errors import AvahazardError

MIN_EVENTS = 3
LARGEST = 1e100
"""The largest covariate whose squares these samplers can sum up."""
BASE = Specification()
FORMS = {"metropolis": ("line", "bend"), "gibbs": ("line",)}
"""The forms of law that each can do."""


def check_method(method: MethodName, specification: Specification) -> None:
    """Raise `AvahazardError` where `method` cannot do what the specification asks."""
    if method not in FORMS:
        return
    asked = {
        "a scatter that changes with volume": specification.scatter != BASE.scatter,
        "normal friction": specification.distribution != BASE.distribution,
        "Student's tails": specification.tails != BASE.tails,
        f"the effect {', '.join(specification.effects)}": bool(specification.effects),
        "a prior from other records": specification.prior is not None and not specification.given,
        "priors as numbers": bool(specification.given),
        f"the {specification.law} law": law(specification.law).form not in FORMS[method],
    }
    for what, wanted in asked.items():
        if wanted:
            raise AvahazardError(
                f"Method {method} does not work with {what}.",
                "Take --method marginal, which does.",
            )


def calibrate_paper(
    observations: Observations,
    specification: Specification,
    method: MethodName,
    *,
    n_chains: int,
    n_draws: int,
    seed: int,
) -> FittedModel:
    """Draw from the posterior of `method` metropolis or gibbs.

    Metropolis: σ is the scatter of recorded elevations, in metres, about F(μ(V)). Gibbs: σ is
    the scatter of the log of apparent friction. Events that the method cannot use are counted.
    Raises `AvahazardError` where the method cannot do it or fewer than three events are left.
    """
    check_method(method, specification)
    chosen = law(specification.law)
    predicted = predict_records(observations, (), {}, float(specification.centrifugal))
    mu = back_calculate(observations, predicted).mu
    keep, left_out = _usable(observations, method, chosen, mu)
    volume = np.exp(observations.columns.log_volume[keep])
    if not chosen.uses_volume:
        volume = np.ones(len(volume))
    if np.any(np.abs(chosen.covariate(volume)) > LARGEST):
        raise AvahazardError(
            f"Volumes reach {volume.max():.3g} m3, with which method {method} cannot calculate.",
            "Mend these records, or take --method marginal.",
        )
    if method == "gibbs":
        chains = gibbs(chosen, volume, mu[keep], seed=seed, n_chains=n_chains, n_draws=n_draws)
    else:
        table, stop_y = _tables(observations, predicted, keep)
        chains = metropolis(
            chosen,
            volume,
            recorded_elevation(observations)[keep],
            table,
            stop_y,
            float(MU[EVEN][0]),
            MU_STEP,
            chosen.start(volume, mu[keep]),
            seed=seed,
            n_chains=n_chains,
            n_draws=n_draws,
        )
    if np.any(chains.draws[..., -1] <= 0.0):
        raise AvahazardError(
            "One friction law stops every block exactly where its record says, which leaves no "
            f"scatter for method {method}.",
            "Take --method marginal, which accounts for measurement error.",
        )
    notes = []
    if left_out:
        reasons = ", ".join(f"{n} {reason}" for reason, n in left_out.items())
        notes.append(
            Note(
                "events_left_out",
                method=method,
                n=sum(left_out.values()),
                total=observations.n_events,
                reasons=reasons,
            )
        )
    if observations.speeds:
        notes.append(Note("no_speeds", method=method))
    posterior = assemble(observations, specification, {})
    slots = (*chosen.coordinates, "log sigma")
    draws = in_slots(posterior.layout, slots, _coordinates(chosen, chains))
    # Volumes are exact to these methods.
    model = fitted_model(posterior, draws, method=method).on(observations)
    return replace(model, sampled=chains, left_out=left_out, notes=tuple(notes))


def recorded_elevation(observations: Observations) -> Floats:
    """Elevation (m) of every recorded stop, `[n_events]`; nan without one."""
    elevation = np.where(
        (observations.kind == LEFT) | (observations.kind == LENGTH), np.nan, observations.observed
    )
    for i in np.flatnonzero(observations.kind == PLACE):
        smooth = observations.sites[observations.columns.path_index[i]].smooth
        elevation[i] = float(smooth.height(observations.observed[i]))
    return elevation


def _usable(
    observations: Observations, method: MethodName, chosen: Law, mu: Floats
) -> tuple[NDArray[np.bool_], dict[str, int]]:
    """The events that the method can use, and the number of others by their first reason."""
    none = np.zeros(observations.n_events, dtype=np.bool_)
    reasons = {
        "left the profile": observations.kind == LEFT,
        "without a volume": none
        if not chosen.uses_volume
        else ~np.isfinite(observations.columns.log_volume),
        "without a profile": observations.kind == LENGTH if method == "metropolis" else none,
        "stopped where no friction stops the block": ~np.isfinite(mu)
        if method == "gibbs"
        else none,
        f"with friction outside {MU[EVEN][0]:.3g} to {MU[EVEN][-1]:.3g}": (mu < MU[EVEN][0])
        | (mu > MU[EVEN][-1])
        if method == "metropolis"
        else none,
    }
    keep = ~none
    left_out = {}
    for reason, lacking in reasons.items():
        if np.any(keep & lacking):
            left_out[reason] = int(np.sum(keep & lacking))
        keep &= ~lacking
    n = int(np.sum(keep))
    if n < MIN_EVENTS:
        why = ", ".join(f"{count} {reason}" for reason, count in left_out.items())
        raise AvahazardError(
            f"Method {method} can use {n} of {observations.n_events} events, and needs {MIN_EVENTS}"
            + (f" ({why})." if why else "."),
            "Take --method marginal, or import more events.",
        )
    return keep, left_out


def _tables(
    observations: Observations, predicted: Predicted, keep: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], Floats]:
    """Row `[n_kept]` of each event's table, and the tables `[n_tables, n_friction]`.

    One for each path and release, over the frictions with one spacing, for which the method's loops
    are made.
    """
    places = np.column_stack([observations.columns.path_index, observations.release])[keep]
    _, first, row = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return row.ravel(), predicted.elevation[keep][first][:, EVEN]


def _coordinates(chosen: Law, chains: Chains) -> Floats:
    """Coordinates of the law and log σ, `[n_chains * n_draws, n_slots]`."""
    natural, sigma = chains.pooled()[:, :-1], chains.pooled()[:, -1:]
    return np.concatenate([chosen.from_natural(natural), np.log(sigma)], axis=-1)
