"""Groups of events held out, whose records are judged at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.scoring.fit_draws import fit_draws
from avahazard.criticism.scoring.held_out import DENSITY_DRAWS, key_of
from avahazard.inference.fitting.mode import Mode
from avahazard.inference.likelihood.posterior import Posterior

Groups = NDArray[np.int64]


def held_out_together(posterior: Posterior, groups: Groups, start: Mode) -> Floats:
    """Log density of all records of each group at once, given those of the others, `[n_groups]`.

    `groups` `[n_events]` says which events are held out together; `start` is the mode given all
    events. Records of one path share its offset: judged one by one, a path that lies off would
    count as often as it has records, and the narrower model, which is the better one within paths,
    would lose for it.
    """
    found = []
    for group in np.unique(groups):
        out = groups == group
        rest = posterior.restricted(~out)
        draws = fit_draws(rest, start, DENSITY_DRAWS, key_of(out))
        given = _together_given(posterior, rest, out, draws.coordinates)
        found.append(float(logsumexp(given + draws.log_weight)))
    return np.array(found)


def _together_given(
    posterior: Posterior, rest: Posterior, out: NDArray[np.bool_], u: Floats
) -> Floats:
    """Log density `[n]` of the records `out`, the offsets of their groups integrated out.

    Given parameters u `[n, n_slots]`, and the other records where these share an offset.
    """
    index = posterior.plan.index
    if np.any(np.intersect1d(index[:, out], index[:, ~out]) >= 0):
        return posterior.log_densities(u) - rest.log_densities(u)
    mine = posterior.restricted(out).log_densities(u)
    return np.asarray(mine - posterior.layout.log_prior(u))
