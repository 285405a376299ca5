"""Chances in cells, against the exceedance of the stops along the line and against sums."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from avahazard.effects.site import stop_table
from avahazard.hazard.chance_map import ALWAYS, annual_chance, friction_field
from avahazard.hazard.exceedance import Avalanches
from avahazard.hazard.extremes import EventVolumes
from avahazard.records.collection import Simulation
from tests.hazard.parabola import avalanches_of, draws

PLACE = np.tile(np.arange(5.0, 1000.0, 10.0), (5, 1))
"""Along the line; the row in the middle is the line."""
VOLUMES, FRICTIONS = (1e3, 1e5), np.linspace(0.1, 0.6, 11)


def _stop(friction: float, volume: float) -> float:
    return float(np.clip(400.0 / friction**0.5 + 20.0 * np.log(volume / 1e3), 50.0, 950.0))


def _runs() -> list[Simulation]:
    runs = []
    for volume in VOLUMES:
        for mu in FRICTIONS:
            stop = _stop(mu, volume)
            width = np.array([1.0, 2.0, 3.0, 2.0, 1.0])[:, None] > 3.0 * mu
            peak = np.where((stop >= PLACE) & width, 2.0 + 0.1 * (stop - PLACE), 0.0)
            hit = PLACE[peak > 1.0]
            farthest = float(hit.max()) if hit.size else np.nan
            runs.append(
                Simulation(
                    "P", "com1dfa", "", mu, volume, 0.0, farthest, False, 1.0,
                    peak.astype(np.float32),
                )
            )  # fmt: skip
    return runs


def _avalanches() -> Avalanches:
    u = draws(0.15, 20)
    nodes = np.log(np.array([1e3, 1e4, 1e5]))
    share = np.tile([0.5, 0.3, 0.2], (20, 1))
    return avalanches_of(u, EventVolumes(np.full(20, 0.3), nodes, share))


def test_on_the_line_it_is_the_chance_that_stops_lie_beyond() -> None:
    avalanches, runs = _avalanches(), _runs()
    chance = annual_chance(avalanches, friction_field(runs, PLACE, 1.0))[0].reshape(PLACE.shape)
    table = stop_table(runs, 0.0, 2000.0)
    fine = np.linspace(0.05, 0.8, 4001)
    for k in range(20, 95, 5):
        rate = 0.0
        for v, share in zip(avalanches.volumes.log_volume, (0.5, 0.3, 0.2), strict=True):
            beyond = fine[table.at(float(np.exp(v)), fine) >= PLACE[2, k]]
            limit = beyond.max() if beyond.size else 1e-9
            limit = ALWAYS if limit == fine[-1] else limit  # beyond the table its end counts
            node = int(np.argmin(np.abs(avalanches.volumes.log_volume - v)))
            z = (np.log(limit) - avalanches.location[0, 0, node]) / avalanches.scatter[0, 0, node]
            rate += 0.3 * share * norm.cdf(z)
        assert chance[2, k] == pytest.approx(-np.expm1(-rate), abs=0.01)


def test_it_falls_with_the_pressure_and_along_the_line_and_is_a_chance() -> None:
    avalanches, runs = _avalanches(), _runs()
    fields = [annual_chance(avalanches, friction_field(runs, PLACE, p)) for p in (1.0, 3.0, 30.0)]
    for found in fields:
        assert ((found >= 0.0) & (found <= 1.0)).all()
        assert (found[1] <= found[0] + 1e-9).all()
        assert (found[0] <= found[2] + 1e-9).all()
        assert (np.diff(found[0].reshape(PLACE.shape)[2]) <= 1e-9).all()
    assert (fields[1][0] <= fields[0][0] + 1e-12).all()
    assert (fields[2][0] <= fields[1][0] + 1e-12).all()
    # No more comes down in a year than starts: at most that one or more of them come.
    assert fields[0][0].max() <= -np.expm1(-0.3) + 1e-9


def test_a_cell_that_no_run_comes_to_has_none_and_one_that_all_cross_has_all() -> None:
    field = friction_field(_runs(), PLACE, 1.0)
    whole = field.friction.reshape(2, *PLACE.shape)
    assert (whole[:, 2, :4] == ALWAYS).all()
    assert (whole[0, :, -1] == 0.0).all()
    # Between volumes straight in their log; at an end of the runs that end counts.
    inside = np.clip(field.friction, FRICTIONS[0], FRICTIONS[-1]).mean(axis=0)
    some = (field.friction[0] > 0.0) & (field.friction[1] < ALWAYS)
    assert field.at(np.log([1e4]))[0][some] == pytest.approx(inside[some])
