"""Slow, obvious twins of the compiled kernels."""

from __future__ import annotations

import numpy as np
from scipy import stats

from avahazard.inference.model.laws import Law


def squared_residuals(u, law: Law, volume, runout, table, stop_y, mu):
    """Σ (y - F(G(V)))², event by event, with numpy's interpolation."""
    total = 0.0
    for i in range(len(volume)):
        friction = float(np.exp(law.log_friction(np.asarray(u), volume[i : i + 1])[0]))
        total += (runout[i] - np.interp(friction, mu, stop_y[table[i]])) ** 2
    return total


def posterior_on_grid(log_density, axes):
    """Means and sds of a density of three parameters by quadrature on a grid."""
    log_p = log_density(*np.meshgrid(*axes, indexing="ij"))
    p = np.exp(log_p - log_p.max())
    p /= p.sum()
    edges = [p[[0, -1]].sum(), p[:, [0, -1]].sum(), p[:, :, [0, -1]].sum()]
    assert max(edges) < 1e-4, "the grid cuts the posterior off"
    means, sds = [], []
    for k, axis in enumerate(axes):
        marginal = p.sum(axis=tuple(j for j in range(3) if j != k))
        mean = marginal @ axis
        means.append(mean)
        sds.append(np.sqrt(marginal @ (axis - mean) ** 2))
    return np.array(means), np.array(sds)


def log_inverse_gamma(sigma, shape, scale):
    """Density of sigma when sigma² is inverse gamma, improper limits included."""
    return -(2 * shape + 1) * np.log(sigma) - scale / sigma**2


def log_normal_prior(value, mean, sd):
    return stats.norm.logpdf(value, mean, sd)
