"""Posterior draws in groups that are alike in the parameters that shape the tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats


def table_groups(parameters: Floats, n_groups: int) -> list[NDArray[np.int64]]:
    """Split draws `[n_draws, n_parameters]` into at most `n_groups` groups of like size.

    The group with the widest parameter (in standard deviations of all draws) is halved at its
    median until there are enough. A group can share one set of tables; the parameters that go
    along with those of the tables (friction falls where drag rises) stay with them.
    """
    groups = [np.arange(len(parameters))]
    spread = np.std(parameters, axis=0)
    known = parameters[:, spread > 0.0] / spread[spread > 0.0]
    if known.shape[1] == 0:
        return groups
    while len(groups) < n_groups:
        widths = [np.ptp(known[g], axis=0) * len(g) for g in groups]
        k = int(np.argmax([width.max() for width in widths]))
        if widths[k].max() == 0.0:
            break
        order = groups[k][np.argsort(known[groups[k], np.argmax(widths[k])], kind="stable")]
        half = len(order) // 2
        groups[k : k + 1] = [order[:half], order[half:]]
    return groups
