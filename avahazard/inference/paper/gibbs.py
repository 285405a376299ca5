"""Gibbs sampling of ν = -log μ = -log a + n V + ε, ε ~ N(0, σ²) (section 2d of Ancey 2005).

With conjugate priors (normal on log a and on n, inverse gamma on σ²) the three full conditionals
are normal, normal and inverse gamma, and need five sums of the data only. Volumes are centred
inside: the level at the mean volume takes the place of log a, with the prior carried over, so the
posterior is the same and the walk does not creep along the line of equal fits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.fitted_model import Chains, chains
from avahazard.inference.model.laws import Law
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
from avahazard.records.errors import AvahazardError

Array = NDArray[np.float64]

N_BURN = 200  # far more than two nearly independent normals need
WEAK_ON_SIGMA = (1.0, 0.01)  # σ of log μ: about 0.04 to 1.4 with 99 %


def gibbs(
    law: Law,
    volume: Array,
    mu: Array,
    *,
    seed: int,
    prior_mean: Array | None = None,
    prior_sd: Array | None = None,
    sigma_prior: tuple[float, float] = WEAK_ON_SIGMA,
    n_chains: int = 4,
    n_draws: int = 5000,
) -> Chains:
    """Posterior draws of the law's natural parameters and of sigma, the sd of log μ.

    `volume` [n_events] in m3 and `mu` [n_events] the apparent friction. Priors are independent
    normals on the law's coordinates (by default the law's own) and inverse gamma (shape, scale)
    on σ². Raises `AvahazardError` for a law whose log friction is not linear in its
    parameters, and for frictions or volumes that are not positive.
    """
    if law.form != "line":
        raise AvahazardError(
            f"Gibbs sampling does not work with the {law.name} law.",
            "Take --method metropolis or marginal, or another law.",
        )
    volume, mu = np.asarray(volume, np.float64), np.asarray(mu, np.float64)
    if not (np.isfinite(volume) & np.isfinite(mu) & (volume > 0) & (mu > 0)).all():
        raise AvahazardError(
            "Gibbs sampling needs a positive friction and volume of every event.",
            "Leave out the events without, or take --method marginal.",
        )
    mean = (law.prior_mean if prior_mean is None else prior_mean) * [-1.0, 1.0][: len(law.names)]
    sd = law.prior_sd if prior_sd is None else prior_sd
    if not law.uses_volume:  # a slope on no covariate: it stays in its prior and is dropped
        mean, sd = np.append(mean, 0.0), np.append(sd, 1.0)
    x = law.covariate(volume)
    draws = regression(x, -np.log(mu), mean, sd, sigma_prior, seed, n_chains, n_draws)
    u = draws[..., :2] * [-1.0, 1.0]
    natural = law.to_natural(u[..., : len(law.names)])
    names, units = (*law.names, "sigma"), (*law.units, "")
    return chains(names, units, np.concatenate([natural, draws[..., 2:]], axis=2))


def regression(
    x: Array,
    y: Array,
    prior_mean: Array,
    prior_sd: Array,
    sigma_prior: tuple[float, float],
    seed: int,
    n_chains: int,
    n_draws: int,
) -> Array:
    """Draws [n_chains, n_draws, 3] of α, β, σ in y = α + β x + N(0, σ²).

    Priors: α and β normal (an infinite sd is flat), σ² inverse gamma (shape, scale); shape -1/2
    and scale 0 are flat on σ. Chains start dispersed over β and σ. Raises `AvahazardError` when
    there are too few records for the priors.
    """
    if sigma_prior[0] + 0.5 * x.size <= 0.5 or x.size < 2:
        raise AvahazardError("Too few events to calibrate on.", "At least three are needed.")
    sums, fitted = _sums(x, y)
    precision = 1.0 / np.square(np.asarray(prior_sd, np.float64))
    if sums[3] == 0 and precision[1] == 0:
        raise AvahazardError(
            "All volumes are equal, so no law of volume can be fitted.", "Take --law constant."
        )
    draws = np.empty((n_chains, n_draws, 3))
    burn = np.empty((N_BURN, 3))
    variance = max(sums[4] / x.size, 1e-12)
    slope_sd = np.sqrt(1.0 / (sums[3] / variance + precision[1]))
    for c in range(n_chains):
        rng = generator(seed, "gibbs", c)
        beta = fitted + 3.0 * slope_sd * rng.standard_normal()
        sigma2 = variance * np.exp(rng.uniform(-2.0, 2.0))
        mean = np.asarray(prior_mean, np.float64)
        beta, sigma2 = run_gibbs(rng, beta, sigma2, sums, mean, precision, *sigma_prior, burn)
        run_gibbs(rng, beta, sigma2, sums, mean, precision, *sigma_prior, draws[c])
    return draws


def _sums(x: Array, y: Array) -> tuple[Array, float]:
    """N, mean x, mean y, Σ(x - mean)², smallest Σ residual², slope; and the fitted slope."""
    dx, dy = x - x.mean(), y - y.mean()
    sxx = float(dx @ dx)
    slope = float(dx @ dy) / sxx if sxx > 0 else 0.0
    rest = dy - slope * dx
    return np.array([x.size, x.mean(), y.mean(), sxx, float(rest @ rest), slope]), slope


@kernel
def run_gibbs(
    rng: np.random.Generator,
    beta: float,
    sigma2: float,
    sums: Array,
    prior_mean: Array,
    prior_precision: Array,
    sigma_shape: float,
    sigma_scale: float,
    draws: Array,
) -> tuple[float, float]:
    """Fills `draws` [n_draws, 3] with α, β, σ; the last β and σ².

    With γ = α + β x̄, the sum of squares is R + N (ȳ - γ)² + S (β - b)², b and R of least squares.
    """
    n, x_mean, y_mean, sxx, rest, fitted = sums
    p_alpha, p_beta = prior_precision[0], prior_precision[1]
    pull_beta = p_beta * prior_mean[1]
    shape = sigma_shape + 0.5 * n
    for i in range(draws.shape[0]):
        w = 1.0 / sigma2
        v = 1.0 / (n * w + p_alpha)
        centre = n * w * y_mean + p_alpha * (prior_mean[0] + beta * x_mean)
        gamma = v * centre + np.sqrt(v) * rng.standard_normal()
        v = 1.0 / (sxx * w + p_alpha * x_mean * x_mean + p_beta)
        centre = sxx * w * fitted + p_alpha * x_mean * (gamma - prior_mean[0]) + pull_beta
        beta = v * centre + np.sqrt(v) * rng.standard_normal()
        squares = rest + n * (y_mean - gamma) ** 2 + sxx * (beta - fitted) ** 2
        sigma2 = (sigma_scale + 0.5 * squares) / rng.standard_gamma(shape)
        draws[i, 0] = gamma - beta * x_mean
        draws[i, 1] = beta
        draws[i, 2] = np.sqrt(sigma2)
    return beta, sigma2
