"""Log determinants and quadratic forms of covariances of band five, many side by side."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.kernels import kernel

WIDTH = 16
"""Covariances that one pass takes: a row waits for the one above, its neighbours here do not."""
ROWS_A_LOG = 8
"""Rows whose pivots are multiplied before a log is taken."""
# What a pass carries from row to row, each of these for all its covariances; two are of the row two
# above. BESIDE is what L has beside its diagonal, WHITE is L⁻¹ z.
SHARE, PIVOT, ONE_OVER, ONE_OVER_2, BESIDE, WHITE, WHITE_2, SQUARE, PRODUCT, LEAST, LOG = range(11)


@kernel
def band_forms(errors: Floats, ground: Floats, z: Floats, share: Floats) -> Floats:
    """log |C| and z' C⁻¹ z `[2, n_shares]` of C = `errors` + share `ground`, for each share.

    `errors`, `ground` `[3, n]` hold upper diagonals as LAPACK keeps them, 0 before these begin, `z`
    is `[n]`. inf and 0 where C is not positive. C = L D L', which one pass down the diagonal gives.
    """
    n_shares = len(share)
    forms = np.empty((2, n_shares))
    state = np.empty(11 * WIDTH)
    for first in range(0, n_shares, WIDTH):
        for k in range(WIDTH):
            state[SHARE * WIDTH + k] = share[min(first + k, n_shares - 1)]
        _pass_down(errors, ground, z, state)
        for k in range(min(WIDTH, n_shares - first)):
            log = state[LOG * WIDTH + k] + np.log(abs(state[PRODUCT * WIDTH + k]))
            positive = state[LEAST * WIDTH + k] > 0.0 and np.isfinite(log)
            forms[0, first + k] = log if positive else np.inf
            forms[1, first + k] = state[SQUARE * WIDTH + k] if positive else 0.0
    return forms


# One array holds all that is carried: so the compiler sees that its parts lie apart.
@kernel(inner=True)
def _pass_down(errors, ground, z, state):  # type: ignore[no-untyped-def]
    for k in range(WIDTH):
        for part in (PIVOT, ONE_OVER, ONE_OVER_2, PRODUCT):
            state[part * WIDTH + k] = 1.0
        for part in (BESIDE, WHITE, WHITE_2, SQUARE, LOG):
            state[part * WIDTH + k] = 0.0
        state[LEAST * WIDTH + k] = np.inf
    for i in range(len(z)):
        error_far, error_near, error = errors[0, i], errors[1, i], errors[2, i]
        ground_far, ground_near, ground_at = ground[0, i], ground[1, i], ground[2, i]
        at = z[i]
        for k in range(WIDTH):
            share = state[SHARE * WIDTH + k]
            beyond = error_far + share * ground_far
            far = beyond * state[ONE_OVER_2 * WIDTH + k]
            near = error_near + share * ground_near - beyond * state[BESIDE * WIDTH + k]
            near *= state[ONE_OVER * WIDTH + k]
            pivot = error + share * ground_at
            pivot -= near * near * state[PIVOT * WIDTH + k] + far * beyond
            white = at - near * state[WHITE * WIDTH + k] - far * state[WHITE_2 * WIDTH + k]
            one_over = 1.0 / pivot
            least = state[LEAST * WIDTH + k]
            state[LEAST * WIDTH + k] = pivot if pivot < least else least
            state[PRODUCT * WIDTH + k] *= pivot
            state[SQUARE * WIDTH + k] += white * white * one_over
            state[PIVOT * WIDTH + k] = pivot
            state[ONE_OVER_2 * WIDTH + k] = state[ONE_OVER * WIDTH + k]
            state[ONE_OVER * WIDTH + k] = one_over
            state[WHITE_2 * WIDTH + k] = state[WHITE * WIDTH + k]
            state[WHITE * WIDTH + k] = white
            state[BESIDE * WIDTH + k] = near
        if i % ROWS_A_LOG == ROWS_A_LOG - 1:
            for k in range(WIDTH):
                state[LOG * WIDTH + k] += np.log(abs(state[PRODUCT * WIDTH + k]))
                state[PRODUCT * WIDTH + k] = 1.0
