"""Random-walk Metropolis-Hastings for a friction law and σ in metres (section 2c of Ancey 2005).

The posterior is prior(Θ) prior(σ) Π_i N(y_i | F_k(G(V_i; Θ)), σ). σ² has an inverse-gamma prior, so
it is integrated out of the acceptance ratio and drawn exactly from its full conditional: the same
posterior as a walk over (Θ, σ), in fewer steps.

The whole cost is the sum of squares. Friction tables lie on a uniform grid, so F(μ) is one
multiplication and one interpolation, and nothing in the loop branches. It is straight across a jump
as elsewhere: as in `likelihood.record_nodes`, the frictions of a record have no gaps.
"""

from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.inference.fitted_model import Chains
from avahazard.inference.model.laws import Law
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel

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
