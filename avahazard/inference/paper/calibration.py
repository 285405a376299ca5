"""The paper's own samplers on observations: Metropolis-Hastings (2c) and Gibbs (2d).

Both use the stops as recorded and the volumes as exact, and no measured speeds.

Metropolis: the posterior is prior(Θ) prior(σ) Π_i N(y_i | F_k(G(V_i; Θ)), σ), σ in metres. σ² has
an inverse-gamma prior, so it is integrated out of the acceptance ratio and drawn exactly from its
full conditional: the same posterior as a walk over (Θ, σ), in fewer steps. The whole cost is the
sum of squares. Friction tables lie on a uniform grid, so F(μ) is one multiplication and one
interpolation, and nothing in the loop branches. It is straight across a jump as elsewhere: as in
`likelihood.record_nodes`, the frictions of a record have no gaps.

Gibbs samples ν = -log μ = -log a + n V + ε, ε ~ N(0, σ²), with conjugate priors (normal on log a
and on n, inverse gamma on σ²), from five sums of the data. Volumes are centred inside: the level at
the mean volume takes the place of log a, with the prior carried over, so that the walk does not
creep along the line of equal fits.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.inference.fitted_model import Chains, FittedModel, fitted_model, in_slots
from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.choices import MethodName
from avahazard.inference.model.laws import Law, law
from avahazard.inference.model.observations import LEFT, LENGTH, PLACE, Observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.paper.apparent import back_calculate
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


FLAT_ON_SIGMA = (-0.5, 0.0)  # inverse-gamma shape and scale of σ² whose limit is flat on σ
TARGET_ACCEPTANCE = 0.35
WARM_UP = 2400
WINDOWS = 12  # of these steps; the shape of the proposal is frozen in the last third
LOG_SCATTER = 0.2  # of log friction, for the first proposals only
FAST_BUT_NAN = {"reassoc", "contract", "nsz", "arcp"}  # all but nnan and ninf


class FitRecords(NamedTuple):
    """Records and the tables that predict them, as the compiled loop wants them.

    `x` [n_events] is what log μ is linear in; `y` [n_events] the recorded stop, m; `offset`
    [n_events] where an event's table begins in `stops`, all tables one after the other. Without
    tables, y itself is linear in x: an ordinary regression. `bends`: the rational law.
    """

    x: Floats
    y: Floats
    offset: Ints
    stops: Floats
    mu_min: float
    mu_step: float
    n_mu: int
    bends: bool


class Prior(NamedTuple):
    """Normals on coordinates (`precision` 0: flat), inverse gamma (`shape`, `scale`) on σ²."""

    mean: Floats
    precision: Floats
    shape: float
    scale: float


def prior_by(mean: Floats, sd: Floats, on_sigma: tuple[float, float]) -> Prior:
    """The prior by standard deviations, of which an infinite one is flat."""
    return Prior(np.asarray(mean, np.float64), 1.0 / np.square(np.asarray(sd)), *on_sigma)


def metropolis(
    law: Law,
    volume: Floats,
    records: FitRecords,
    start: Floats,
    *,
    seed: int,
    sigma_prior: tuple[float, float] = FLAT_ON_SIGMA,
    n_chains: int = 4,
    n_draws: int = 5000,
) -> Chains:
    """Posterior draws of the law's natural parameters and of sigma, m.

    `volume` [n_events] in m3, `records` from `runout_records`, `start` [n_coordinates] from
    `Law.start`. Priors are those of the law and inverse gamma (shape, scale) on σ².
    """
    prior = prior_by(law.prior_mean, law.prior_sd, sigma_prior)
    spread = _first_spread(law, volume, start)
    draws, sigma, acceptance = walk(records, prior, start, spread, seed, n_chains, n_draws)
    natural = np.concatenate([law.to_natural(draws), sigma[..., None]], axis=2)
    return Chains((*law.names, "sigma"), (*law.units, "m"), natural, acceptance)


def walk(
    records: FitRecords,
    prior: Prior,
    start: Floats,
    spread: Floats,
    seed: int,
    n_chains: int,
    n_draws: int,
) -> tuple[Floats, Floats, Floats]:
    """Draws [n_chains, n_draws, n_coordinates], sigma [n_chains, n_draws], acceptance [n_chains].

    `spread` [n_coordinates, n_coordinates] is the lower Cholesky factor of a guess of the
    posterior's covariance; the chains start three such sds around `start`.
    """
    draws = np.empty((n_chains, n_draws, start.size))
    sigma = np.empty((n_chains, n_draws))
    acceptance = np.empty(n_chains)
    for c in range(n_chains):
        rng = generator(seed, "metropolis", c)
        u = start + 3.0 * spread @ rng.standard_normal(start.size)
        u, proposal = _warm_up(rng, u, spread, records, prior)
        _, acceptance[c] = run_chain(rng, u, proposal, records, prior, draws[c], sigma[c])
    return draws, sigma, acceptance


def _warm_up(
    rng: np.random.Generator, u: Floats, spread: Floats, records: FitRecords, prior: Prior
) -> tuple[Floats, Floats]:
    """The point reached, and the proposal: diagonal in the coordinates that the chain showed."""
    n_window, d = WARM_UP // WINDOWS, u.size
    scale = 2.4 / np.sqrt(d)
    seen = np.empty((WINDOWS, n_window, d))
    sigma = np.empty(n_window)
    for w in range(WINDOWS):
        u, rate = run_chain(rng, u, scale * spread, records, prior, seen[w], sigma)
        scale *= np.exp(2.0 * (rate - TARGET_ACCEPTANCE))
        if 2 <= w < WINDOWS * 2 // 3 and rate > 0.05:
            later = seen[w // 2 : w + 1].reshape(-1, d)
            covariance = np.atleast_2d(np.cov(later, rowvar=False))
            if np.linalg.cond(covariance) < 1e12:
                old = np.linalg.slogdet(spread)[1]
                spread = np.asarray(np.linalg.cholesky(covariance), np.float64)
                scale *= np.exp((old - np.linalg.slogdet(spread)[1]) / d)
    return u, scale * spread


@kernel
def run_chain(
    rng: np.random.Generator,
    start: Floats,
    proposal: Floats,
    records: FitRecords,
    prior: Prior,
    draws: Floats,
    sigma: Floats,
) -> tuple[Floats, float]:
    """Fills `draws` [n_draws, n_coordinates] and `sigma` [n_draws]; last point and acceptance.

    The step is `proposal` [n_coordinates, n_coordinates], lower triangular, times normals.
    """
    d = start.size
    shape = prior.shape + 0.5 * records.y.size
    u, candidate, z = start.copy(), start.copy(), np.empty(d)
    place = np.empty(records.y.size)
    half_sum = 0.5 * squared_residuals(u, records, place) + prior.scale
    log_p = _log_prior(u, prior) - shape * np.log(half_sum)
    accepted = 0
    for i in range(draws.shape[0]):
        for j in range(d):
            z[j] = rng.standard_normal()
            step = 0.0
            for k in range(j + 1):
                step += proposal[j, k] * z[k]
            candidate[j] = u[j] + step
        new_sum = 0.5 * squared_residuals(candidate, records, place) + prior.scale
        new_p = _log_prior(candidate, prior) - shape * np.log(new_sum)
        if -rng.standard_exponential() < new_p - log_p:
            u[:] = candidate
            half_sum, log_p = new_sum, new_p
            accepted += 1
        draws[i] = u
        sigma[i] = np.sqrt(half_sum / rng.standard_gamma(shape))
    return u, accepted / max(draws.shape[0], 1)


@kernel(inner=True, fastmath=FAST_BUT_NAN, inline="always")
def _exp(x: float) -> float:
    """e^x for |x| < 36 to 1e-12, without a branch, so that the loop over events runs in vectors."""
    r = min(max(x, -36.0), 36.0) * (1.0 / 256.0)
    p = 1.0 + r * (1 / 5 + r * (1 / 30 + r * (1 / 210 + r * (1 / 1680 + r * (1 / 15120)))))
    p = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 * p))))
    return p**256


@kernel(fastmath=FAST_BUT_NAN)
def squared_residuals(u: Floats, records: FitRecords, place: Floats) -> float:
    """Σ (y_i - F(G(V_i; u)))², m2, of the coordinates u [n_coordinates] of a law.

    `place` [n_events] is working memory. Three plain loops, since each then runs in vectors.
    """
    x, y, offset, stops = records.x, records.y, records.offset, records.stops
    slope = u[1] if u.size > 1 else 0.0
    total = 0.0
    if stops.size == 0:
        for i in range(x.size):
            total += (y[i] - u[0] + slope * x[i]) ** 2
        return total
    last_cell = records.n_mu - 2
    start, per_step, last = records.mu_min, 1.0 / records.mu_step, records.n_mu - 1.0
    if records.bends:
        a, n = np.exp(min(u[0], 36.0)), np.exp(min(u[2], 36.0))
        for i in range(x.size):
            mu = a / (1.0 + _exp(n * (x[i] - slope)))
            place[i] = min(max((mu - start) * per_step, 0.0), last)
    else:
        for i in range(x.size):
            mu = _exp(u[0] - slope * x[i])
            place[i] = min(max((mu - start) * per_step, 0.0), last)
    for i in range(x.size):
        cell = min(int(place[i]), last_cell)
        low = stops[offset[i] + cell]
        high = stops[offset[i] + cell + 1]
        total += (y[i] - low - (high - low) * (place[i] - cell)) ** 2
    return total


@kernel(inner=True)
def _log_prior(u: Floats, prior: Prior) -> float:
    total = 0.0
    for j in range(u.size):
        total -= 0.5 * prior.precision[j] * (u[j] - prior.mean[j]) ** 2
    return total


def _first_spread(law: Law, volume: Floats, start: Floats) -> Floats:
    """Cholesky factor of the coordinates' covariance if log friction scattered by `LOG_SCATTER`."""
    steps: Floats = 1e-5 * np.eye(start.size)
    jacobian = (law.log_friction(start + steps, volume) - law.log_friction(start, volume)) / 1e-5
    information = jacobian @ jacobian.T / LOG_SCATTER**2 + np.diag(law.prior_sd**-2.0 + 1e-6)
    return np.linalg.cholesky(np.linalg.inv(information))


def runout_records(
    law: Law,
    volume: Floats,
    runout: Floats,
    table: Ints,
    stop_y: Floats,
    mu_min: float,
    mu_step: float,
) -> FitRecords:
    """Records of runouts [n_events], m, each with its volume, m3, and the row of its table.

    `stop_y` [n_tables, n_mu] holds the elevation of the stop on the grid mu_min + j mu_step, and
    must be finite: the end of the profile where it was left, the release where nothing moved.
    Friction outside of the grid counts as its end.
    """
    x = law.covariate(volume)
    stops = np.ascontiguousarray(stop_y, np.float64)
    n_mu = int(stops.shape[1])
    offset = np.asarray(table, np.int64) * n_mu
    bends = law.form == "bend"
    return FitRecords(x, runout, offset, stops.ravel(), float(mu_min), float(mu_step), n_mu, bends)


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
