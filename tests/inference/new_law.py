"""A law that the program does not have: of two parameters, linear in no covariate."""

from __future__ import annotations

import numpy as np

from avahazard.inference.model.laws import Law

NAME = "halving"


def halving() -> Law:
    """Return μ = a / (1 + V/c)."""
    return Law(
        name=NAME,
        formula="μ = a / (1 + V/c)",
        words="falls with volume as a / (1 + V/c)",
        names=("a", "c"),
        units=("", "m3"),
        coordinates=("log a", "log c in 1e5 m3"),
        prior_mean=np.array([np.log(0.5), 0.0]),
        prior_sd=np.array([0.5, 2.5]),
        log_friction=lambda u, v: u[..., 0:1] - np.log1p(v / (1e5 * np.exp(u[..., 1:2]))),
        slopes=lambda u, v: np.stack([np.ones_like(v), v / (v + 1e5 * np.exp(u[1]))]),
        to_natural=lambda u: np.stack([np.exp(u[..., 0]), 1e5 * np.exp(u[..., 1])], axis=-1),
        from_natural=lambda p: np.stack([np.log(p[..., 0]), np.log(p[..., 1] / 1e5)], axis=-1),
        begin=lambda v, log_mu: np.array([log_mu.mean() + 0.7, np.log(np.median(v) / 1e5)]),
    )
