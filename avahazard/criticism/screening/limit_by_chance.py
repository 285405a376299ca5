"""What an estimated limit of sight gains without a parameter fitted anew: mostly chance.

A limit just above the highest stop of a path makes every record there likelier, by about one nat a
path where nothing is hidden, and that varies as an exponential does. It is most of what such limits
gain by chance. Where stops are missing the gain is in what follows: law and scatter move.
"""

from __future__ import annotations

import numpy as np
from scipy.special import log_ndtr, stdtr

from avahazard.arrays import Floats
from avahazard.criticism.screening.laplace_fit import Design, Edges, LaplaceFit
from avahazard.inference.model.friction_scatter import DEGREES

SHARE = 0.5
"""Share of it that is left out of what the test of sight goes by: all of it is chance where nothing
is hidden, some of it is not where much is."""


def limit_by_chance(
    edges: Edges, known: Edges, design: Design, fit: LaplaceFit, variance: Floats, student: bool
) -> float:
    """Gain (nats) of `edges` of sight over those `known`, at the model's own fit to a world.

    `variance` `[n_events]` is that of log friction from the records. Groups' offsets count with
    their spread.
    """
    located = design.constant + design.x @ fit.coefficients
    blur = np.maximum(edges.seen_sd**2, variance)
    tau2 = fit.tau**2
    shared = (design.places >= 0).T @ tau2 + design.alone.T @ tau2
    own = (np.exp(fit.log_scatter) * design.multiplier) ** 2
    z = (edges.seen - located) / np.sqrt(own + shared + blur + design.extra)
    log_seen = np.log(stdtr(float(DEGREES), z)) if student else log_ndtr(z)
    return float(-np.sum(log_seen[edges.has_limit & ~known.has_limit]))
