"""The paper's own samplers on observations: Metropolis-Hastings (2c) and Gibbs (2d).

Both use the stops as recorded and the volumes as exact, and no measured speeds. Gibbs samples
ν = -log μ = -log a + n V + ε, ε ~ N(0, σ²), with conjugate priors (normal on log a and on n,
inverse gamma on σ²), from five sums of the data. Volumes are centred inside: the level at the mean
volume takes the place of log a, with the prior carried over, so that the walk does not creep along
the line of equal fits.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.fitted_model import Chains, FittedModel, fitted_model, in_slots
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.laws import Law, law
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import back_calculate
from avahazard.inference.paper.metropolis import Prior, metropolis, prior_by, runout_records
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
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
        "the runs of a flow model": specification.forward != BASE.forward,
        f"the {specification.law} law": law(specification.law).form not in FORMS[method],
    }
    for what, wanted in asked.items():
        if wanted:
            raise AvahazardError(
                f"Method {method} does not work with {what}.", "Take --method marginal, which does."
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
            "Correct these records, or take --method marginal.",
        )
    length: dict[str, Any] = {"seed": seed, "n_chains": n_chains, "n_draws": n_draws}
    if method == "gibbs":
        drawn = gibbs(chosen, volume, mu[keep], **length)
    else:
        stops = recorded_elevation(observations)[keep]
        # A table for each path and release, over the frictions with one spacing, for which the
        # method's loops are made.
        places = np.column_stack([observations.columns.path_index, observations.release])[keep]
        _, first, row = np.unique(places, axis=0, return_index=True, return_inverse=True)
        tables = row.ravel(), predicted.elevation[keep][first][:, EVEN], float(MU[EVEN][0]), MU_STEP
        records = runout_records(chosen, volume, stops, *tables)
        drawn = metropolis(chosen, volume, records, chosen.start(volume, mu[keep]), **length)
    if np.any(drawn.draws[..., -1] <= 0.0):
        raise AvahazardError(
            "One friction law stops every block exactly where its record says, which leaves no "
            f"scatter for method {method}.",
            "Take --method marginal, which accounts for measurement error.",
        )
    notes = []
    if left_out:
        reasons = ", ".join(f"{n} {reason}" for reason, n in left_out.items())
        n, total = sum(left_out.values()), observations.n_events
        told = {"method": method, "n": n, "total": total, "reasons": reasons}
        notes.append(Note("events_left_out", **told))
    if observations.speeds:
        notes.append(Note("no_speeds", method=method))
    posterior = assemble(observations, specification, {})
    slots = (*chosen.coordinates, "log sigma")
    natural, sigma = np.split(drawn.pooled(), [-1], axis=1)
    coordinates = np.concatenate([chosen.from_natural(natural), np.log(sigma)], axis=-1)
    draws = in_slots(posterior.layout, slots, coordinates)
    # Volumes are exact to these methods.
    model = fitted_model(posterior, draws, method=method).on(observations)
    return replace(model, sampled=drawn, left_out=left_out, notes=tuple(notes))


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
    low, high = MU[EVEN][[0, -1]]
    reasons = {"beyond the profile": observations.kind == LEFT}
    if chosen.uses_volume:
        reasons["without a volume"] = ~np.isfinite(observations.columns.log_volume)
    if method == "metropolis":
        reasons["without a profile"] = observations.kind == LENGTH
        reasons[f"with friction outside {low:.3g} to {high:.3g}"] = (mu < low) | (mu > high)
    else:
        reasons["stopped where no friction stops the block"] = ~np.isfinite(mu)
    keep = np.ones(observations.n_events, dtype=np.bool_)
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


N_BURN = 200  # far more than two nearly independent normals need
WEAK_ON_SIGMA = (1.0, 0.01)  # σ of log μ: about 0.04 to 1.4 with 99 %


def gibbs(
    law: Law, volume: Floats, mu: Floats, *, seed: int, n_chains: int = 4, n_draws: int = 5000
) -> Chains:
    """Posterior draws of the law's natural parameters and of sigma, the sd of log μ.

    `volume` [n_events] in m3 and `mu` [n_events] the apparent friction. Priors are those of the
    law, whose log friction is linear in its parameters, and `WEAK_ON_SIGMA` on σ².
    """
    mean, sd = law.prior_mean * [-1.0, 1.0][: len(law.names)], law.prior_sd
    if not law.uses_volume:  # a slope on no covariate: it stays in its prior and is dropped
        mean, sd = np.append(mean, 0.0), np.append(sd, 1.0)
    prior = prior_by(mean, sd, WEAK_ON_SIGMA)
    draws = regression(law.covariate(volume), -np.log(mu), prior, seed, n_chains, n_draws)
    u = draws[..., :2] * [-1.0, 1.0]
    natural = law.to_natural(u[..., : len(law.names)])
    names, units = (*law.names, "sigma"), (*law.units, "")
    return Chains(names, units, np.concatenate([natural, draws[..., 2:]], axis=2))


def regression(
    x: Floats, y: Floats, prior: Prior, seed: int, n_chains: int, n_draws: int
) -> Floats:
    """Draws [n_chains, n_draws, 3] of α, β, σ in y = α + β x + N(0, σ²).

    A prior of shape -1/2 and scale 0 is flat on σ. Chains start dispersed over β and σ.
    """
    sums = _sums(x, y)
    draws = np.empty((n_chains, n_draws, 3))
    burn = np.empty((N_BURN, 3))
    variance = max(sums[4] / x.size, 1e-12)
    slope_sd = np.sqrt(1.0 / (sums[3] / variance + prior.precision[1]))
    for c in range(n_chains):
        rng = generator(seed, "gibbs", c)
        beta = sums[5] + 3.0 * slope_sd * rng.standard_normal()
        sigma2 = variance * np.exp(rng.uniform(-2.0, 2.0))
        beta, sigma2 = run_gibbs(rng, beta, sigma2, sums, prior, burn)
        run_gibbs(rng, beta, sigma2, sums, prior, draws[c])
    return draws


def _sums(x: Floats, y: Floats) -> Floats:
    """N, mean x, mean y, Σ(x - mean)², smallest Σ residual², and the slope that gives it."""
    dx, dy = x - x.mean(), y - y.mean()
    sxx = float(dx @ dx)
    slope = float(dx @ dy) / sxx if sxx > 0 else 0.0
    rest = dy - slope * dx
    return np.array([x.size, x.mean(), y.mean(), sxx, float(rest @ rest), slope])


@kernel
def run_gibbs(
    rng: np.random.Generator, beta: float, sigma2: float, sums: Floats, prior: Prior, draws: Floats
) -> tuple[float, float]:
    """Fills `draws` [n_draws, 3] with α, β, σ; the last β and σ².

    With γ = α + β x̄, the sum of squares is R + N (ȳ - γ)² + S (β - b)², b and R of least squares.
    """
    n, x_mean, y_mean, sxx, rest, fitted = sums
    p_alpha, p_beta = prior.precision[0], prior.precision[1]
    pull_beta = p_beta * prior.mean[1]
    shape = prior.shape + 0.5 * n
    for i in range(draws.shape[0]):
        w = 1.0 / sigma2
        v = 1.0 / (n * w + p_alpha)
        centre = n * w * y_mean + p_alpha * (prior.mean[0] + beta * x_mean)
        gamma = v * centre + np.sqrt(v) * rng.standard_normal()
        v = 1.0 / (sxx * w + p_alpha * x_mean * x_mean + p_beta)
        centre = sxx * w * fitted + p_alpha * x_mean * (gamma - prior.mean[0]) + pull_beta
        beta = v * centre + np.sqrt(v) * rng.standard_normal()
        squares = rest + n * (y_mean - gamma) ** 2 + sxx * (beta - fitted) ** 2
        sigma2 = (prior.scale + 0.5 * squares) / rng.standard_gamma(shape)
        draws[i, 0] = gamma - beta * x_mean
        draws[i, 1] = beta
        draws[i, 2] = np.sqrt(sigma2)
    return beta, sigma2
