"""Which effects look alike on these data: correlation of what they do to friction."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.likelihood.posterior import Posterior


def explained(fit: Refit, base: Refit) -> Floats:
    """What an effect changes.

    Log friction that each record asks for less what the law gives, the base model's minus the
    fit's, `[n_events]`.
    """
    return _residual(base) - _residual(fit)


def _residual(fit: Refit) -> Floats:
    posterior = fit.posterior
    nodes = posterior.nodes.at(fit.mode.u)
    asked = np.log(np.maximum(likely_friction(nodes, posterior.layout.log_scatter), 1e-3))
    given, _ = posterior.location_and_scatter(fit.mode.u)
    mean = np.sum(given * posterior.observations.volumes.weight, axis=1)
    if not posterior.layout.log_scatter:
        mean = np.log(np.maximum(mean, 1e-3))
    # An event that left asks for no certain friction.
    return np.asarray(np.nan_to_num(asked - mean))


def correlation(first: Floats, second: Floats, posterior: Posterior) -> float:
    """Correlation of two changes once law and paths have taken their part (least squares)."""
    volume = np.exp(posterior.observations.volumes.mean)
    groups = posterior.observations.columns.path_index
    nuisance = np.column_stack(
        [np.ones(len(volume)), volume / np.mean(volume), np.log(volume)]
        + [groups == k for k in np.unique(groups)[1:]]
    ).astype(float)

    def rest(values: Floats) -> Floats:
        return np.asarray(values - nuisance @ np.linalg.lstsq(nuisance, values, rcond=None)[0])

    a, b = rest(first), rest(second)
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 1e-12 else 0.0
