"""Worlds have the statistics that they say they have."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.synth.making import make_world
from avahazard.synth.settings import Power, Settings
from avahazard.synth.world import World
from tests.synth.worlds import residuals, truth_column, world


def test_same_seed_same_world_and_another_seed_another() -> None:
    one, two, other = (world(seed, n_events=60, n_paths=4) for seed in (1, 1, 2))
    assert one[0].events == two[0].events
    assert one[1] == two[1]
    assert one[0].events != other[0].events


def test_friction_follows_the_law_with_its_scatter() -> None:
    _, truth = world(3, n_events=3000, n_paths=6)
    volume, mu = truth_column(truth, "volume_m3"), truth_column(truth, "mu")
    slope, level = np.polyfit(volume, np.log(mu), 1)
    assert level == pytest.approx(np.log(0.5), abs=0.015)
    assert slope == pytest.approx(-7e-7, rel=0.1)
    assert residuals(truth).std() == pytest.approx(1.0, abs=0.05)


def test_power_law() -> None:
    _, truth = world(3, n_events=2000, n_paths=6, settings=Settings(law=Power()))
    assert truth["law"] == {"name": "power", "alpha": 1.83, "beta": 0.12}
    logs = np.log(truth_column(truth, "volume_m3")), np.log(truth_column(truth, "mu"))
    # What is too rough to start is not seen: with this law some of the smallest.
    assert np.polyfit(*logs, 1)[0] == pytest.approx(-0.12, abs=0.015)


def test_tails_are_heavy_where_asked() -> None:
    plain = residuals(world(3, n_events=2000)[1])
    heavy = residuals(world(3, n_events=2000, settings=Settings(student_df=3.0))[1])
    assert (abs(plain) > 4.0).sum() <= 1
    assert (abs(heavy) > 4.0).sum() > 10


def test_volumes_are_recorded_with_their_error() -> None:
    records, truth = world(4, n_events=2000, settings=Settings(volume_rel_sigma=0.4))
    recorded = np.array([e.volume_m3 for e in records.events])
    error = np.log(recorded / truth_column(truth, "volume_m3"))
    assert error.std() == pytest.approx(0.4, rel=0.05)
    assert abs(error.mean()) < 0.03
    assert {e.volume_rel_sigma for e in records.events} == {0.4}


def test_too_few_events_are_refused() -> None:
    with pytest.raises(AvahazardError, match="cannot be spread"):
        make_world(1, n_events=5, n_paths=9)


def test_avalanches_that_never_start_are_an_error() -> None:
    def glue(world: World, strength: float) -> dict[str, object]:
        world.log_mu += strength
        return {}

    with pytest.raises(AvahazardError, match="Too few avalanches"):
        make_world(1, 20, 2, {"glue": 3.0}, own_effects={"glue": glue})


def test_effect_of_ones_own_is_applied_and_told() -> None:
    def waxed(world: World, strength: float) -> dict[str, object]:
        world.log_mu -= 0.1 * strength
        return {"log_mu": -0.1 * strength}

    _, truth = world(
        1, n_events=40, n_paths=2, effects={"waxed": 2.0}, own_effects={"waxed": waxed}
    )
    _, base = world(1, n_events=40, n_paths=2)
    assert truth["effects"] == {"waxed": {"strength": 2.0, "parameters": {"log_mu": -0.2}}}
    ratio = truth_column(truth, "mu_median") / truth_column(base, "mu_median")
    assert np.median(ratio) == pytest.approx(np.exp(-0.2))
