"""Runs of the block down a path: the batch kernel over friction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from avahazard.physics.cell_motion import (
    at_speed,
    elevation_in_cell,
    end_accelerations,
    first_zero,
    fly,
)
from avahazard.physics.cells import Cells
from avahazard.physics.constants import KEEPS_NAN

Floats = NDArray[np.float64]

STOPPED, LEFT_PROFILE, NOT_RELEASED = 0, 1, 2
STATUS_NAMES = ("stopped", "left_profile", "not_released")
LANES = 32
"""Frictions that go through a cell together: enough for the widest registers."""


class Stops(NamedTuple):
    """Ends of runs, each array `[n_starts, n_friction]`.

    `x`, `y` (m) are nan where the block left the profile and the release where it was not
    released; `status` is one of STOPPED, LEFT_PROFILE, NOT_RELEASED; `lift_off_x` is where the
    block first lost contact with its bed, nan where it never did.
    """

    x: Floats
    y: Floats
    status: NDArray[np.int8]
    lift_off_x: Floats


def run(cells: Cells, starts: NDArray[np.int64], mu: Floats) -> Stops:
    """Run the block from each start node with each friction.

    `starts` `[n_starts]` are node indices, `mu` `[n_friction]` Coulomb frictions (any order;
    neighbours that are close run fastest).
    """
    return Stops(*_run(cells, np.asarray(starts, dtype=np.int64), np.asarray(mu, dtype=np.float64)))


@njit(cache=True, fastmath=KEEPS_NAN)
def _run(cells, starts, mu):  # type: ignore[no-untyped-def]
    n_starts, n_mu, n_cells = len(starts), len(mu), len(cells.length)
    stop_x = np.full((n_starts, n_mu), np.nan)
    stop_y = np.full((n_starts, n_mu), np.nan)
    lift_off_x = np.full((n_starts, n_mu), np.nan)
    status = np.full((n_starts, n_mu), LEFT_PROFILE, dtype=np.int8)
    friction = np.empty(LANES)
    w = np.empty(LANES)
    w_new = np.empty(LANES)
    moving = np.zeros(LANES, dtype=np.int64)
    flag = np.zeros(LANES, dtype=np.int64)
    for s in range(n_starts):
        for first in range(0, n_mu, LANES):
            n_lanes = min(LANES, n_mu - first)
            n_moving = 0
            for j in range(LANES):
                friction[j] = mu[first + min(j, n_lanes - 1)]
                w[j] = 0.0
                moving[j] = 0
                if j < n_lanes:
                    if starts[s] < n_cells and _releases(cells, starts[s], friction[j]):
                        moving[j] = 1
                        n_moving += 1
                    else:
                        status[s, first + j] = NOT_RELEASED
                        stop_x[s, first + j] = cells.x[starts[s]]
                        stop_y[s, first + j] = cells.y[starts[s]]
            for i in range(starts[s], n_cells):
                if n_moving == 0:
                    break
                if not cell_step(cells, i, friction, moving, w, w_new, flag):
                    # Every lane is plain: past any dip and on the ground.
                    for j in range(LANES):
                        w[j] = w_new[j]
                    continue
                for j in range(n_lanes):
                    if flag[j] == 0:
                        continue
                    w_end, t_stop, t_lost = finish_cell(cells, i, friction[j], w[j], w_new[j])
                    h = cells.x[i + 1] - cells.x[i]
                    if t_lost >= 0.0 and np.isnan(lift_off_x[s, first + j]):
                        lift_off_x[s, first + j] = cells.x[i] + t_lost * h
                    if t_stop >= 0.0:
                        moving[j] = 0
                        n_moving -= 1
                        status[s, first + j] = STOPPED
                        stop_x[s, first + j] = cells.x[i] + t_stop * h
                        stop_y[s, first + j] = elevation_in_cell(cells, i, t_stop)
                    w_new[j] = w_end
                for j in range(LANES):
                    w[j] = w_new[j]
    return stop_x, stop_y, status, lift_off_x


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def _releases(cells, start, mu):  # type: ignore[no-untyped-def]
    """Whether the block starts to move: the slope at the release exceeds what holds it."""
    pull, _ = end_accelerations(cells, start, mu, 0.0, 0.0)
    return pull > 0.0


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def cell_step(cells, i, friction, moving, w, w_new, flag):  # type: ignore[no-untyped-def]
    """Step all lanes through cell i in closed form; True if one that moves needs a closer look."""
    g0, g1, g2, g3 = cells.growth[i, 0], cells.growth[i, 1], cells.growth[i, 2], cells.growth[i, 3]
    g4, g5, g6 = cells.growth[i, 4], cells.growth[i, 5], cells.growth[i, 6]
    d0, d1, d2, d3 = cells.drive[i, 0], cells.drive[i, 1], cells.drive[i, 2], cells.drive[i, 3]
    d4, d5, d6 = cells.drive[i, 4], cells.drive[i, 5], cells.drive[i, 6]
    factor, offset = cells.factor[i], cells.offset[i]
    dip, lift = cells.dip[i], cells.lift[i]
    flags = 0
    if cells.speed_dependent:
        for j in range(LANES):
            w_mid = w[j]
            value = w_mid
            for _ in range(3):
                m = friction[j] * factor * at_speed(cells.speed_factor, w_mid) + offset
                push = -2.0 * at_speed(cells.speed_constant, w_mid) * cells.length[i]
                growth = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
                drive = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
                value = growth * w[j] + drive + push
                w_mid = 0.5 * (w[j] + max(value, 0.0))
            w_new[j] = value
            odd = (value <= dip) | (max(value, w[j]) > lift)
            flag[j] = moving[j] if odd else 0
            flags += flag[j]
        return flags > 0
    for j in range(LANES):
        m = friction[j] * factor + offset
        growth = g0 + m * (g1 + m * (g2 + m * (g3 + m * (g4 + m * (g5 + m * g6)))))
        drive = d0 + m * (d1 + m * (d2 + m * (d3 + m * (d4 + m * (d5 + m * d6)))))
        value = growth * w[j] + drive
        w_new[j] = value
        odd = (value <= dip) | (max(value, w[j]) > lift)
        flag[j] = moving[j] if odd else 0
        flags += flag[j]
    return flags > 0


@njit(cache=True, fastmath=KEEPS_NAN, forceinline=True)
def finish_cell(cells, i, mu, w0, w1):  # type: ignore[no-untyped-def]
    """The step of one block through cell i that may stop or lose the ground there.

    Returns w at the end, and the fractions of the cell where it stopped and where it first
    lost contact (-1: neither).
    """
    if w0 > cells.lift[i] or w1 > cells.lift[i]:
        return fly(cells, i, mu, w0)
    h = cells.x[i + 1] - cells.x[i]
    a0, a1 = end_accelerations(cells, i, mu, w0, w1)
    t = first_zero(w0, h * a0, w1, h * a1)
    return w1, t, -1.0
