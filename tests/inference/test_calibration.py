"""Simulation-based calibration of the marginal method, with effects of several kinds."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.inference.model.observations import LEFT
from avahazard.inference.sampling import sample
from avahazard.inference.seeds import generator
from tests.inference.sbc import LEVEL, N_DRAWS, N_WORLDS, least_p, p_value, rank
from tests.inference.sbc_records import Case
from tests.inference.sbc_worlds import world

COLUMNS = ("snow-type", "path-section", "release-elevation", "season", "covariate:wind")
PLACES = (150.0, 300.0, 450.0)
CASES = {
    "law": Case(),
    "power law": Case(law="power"),
    "volume error": Case(n_events=80, volume_error=0.3),
    "volume-scatter": Case(("volume-scatter",)),
    "observation limit": Case(seen_below=480.0),
    "observation limit, vague records": Case(seen_below=480.0, record_error=(60.0, 120.0)),
    "winter and storm": Case(("winter-effect", "storm-effect"), 72, n_worlds=30),
    "columns": Case(COLUMNS, 48, 4, dropped=200.0, n_worlds=40),
    "cohesion": Case(("cohesion",), a=0.42, n_worlds=30),
    "path-effect": Case(("path-effect",), 48, 8, n_worlds=60),
    "record-error": Case(("record-error",), n_worlds=60),
    "two-kinds": Case(("two-kinds",), 60, n_worlds=40),
    "turbulent-drag": Case(("turbulent-drag",), a=0.3, n_worlds=40),
    "forest-drag": Case(("forest-drag",), a=0.35, n_worlds=30),
    "entrainment": Case(("entrainment",), a=0.4, dropped=300.0, n_worlds=30),
    "epoch-bias": Case(("epoch-bias",), n_worlds=40),
    "no load of curvature": Case(centrifugal=False, n_worlds=30),
    "rational law": Case(law="rational", n_events=60, a=0.6, n_worlds=30),
    "asymptotic law": Case(law="asymptotic", n_events=60, a=0.6, n_worlds=30),
    "observation-limit": Case(("observation-limit",), seen_below=600.0, n_worlds=30),
    "leading-edge": Case(("leading-edge",), n_worlds=40),
    "volume-error": Case(
        ("volume-error",), 60, a=0.65, volume=1.6e5, volume_error=0.3, n_worlds=30
    ),
    "speed-weakening": Case(("speed-weakening",), a=0.6, n_worlds=30),
    "tracks": Case(speeds=PLACES, a=0.5, n_worlds=30),
    "tracks with drag": Case(("turbulent-drag",), speeds=PLACES, a=0.3, n_worlds=30),
    "drag and weakening": Case(
        ("turbulent-drag", "speed-weakening"), speeds=PLACES, a=0.5, n_worlds=30
    ),
    "drag and entrainment": Case(
        ("turbulent-drag", "entrainment"), a=0.3, dropped=300.0, n_worlds=30
    ),
}


def _ranks(name: str, n_worlds: int, fault: float = 0.0) -> tuple[list[str], np.ndarray, float]:
    """Ranks `[n_worlds, n_slots]` of the truth among draws, and the share beyond the profile."""
    ranks, left, names = [], [], []
    for w in range(n_worlds):
        model, u = world(CASES[name], generator(20050, name, w), fault)
        found = sample(model, n_chains=2, n_draws=250, seed=w)
        ranks.append(rank(found.draws, u))
        left.append(np.mean(model.observations.kind == LEFT))
        names = [s.name for s in model.layout.slots]
    return names, np.array(ranks), float(np.mean(left))


def test_the_judge_tells_uniform_ranks_from_others() -> None:
    rng = np.random.default_rng(2)
    assert p_value(rng.integers(0, N_DRAWS + 1, N_WORLDS)) > LEVEL
    narrow = np.clip(rng.normal(50.0, 18.0, N_WORLDS), 0, N_DRAWS).astype(int)
    assert p_value(narrow) < LEVEL
    assert p_value(np.minimum(rng.integers(0, N_DRAWS + 1, N_WORLDS) + 18, N_DRAWS)) < LEVEL


@pytest.mark.slow
@pytest.mark.parametrize("w", [1, 3, 4, 6, 7, 11])
def test_draws_keep_to_what_tables_made_on_the_spot_give(w: int) -> None:
    """Datasets whose posteriors reach past the grids about their modes.

    Between coarse grid points the interpolated likelihood peaked, 10 to 46 nats too high. A star
    with a long ridge errs by several nats at single draws of the last, and by 0.2 to 2.2 nats (root
    mean square) at those of each dataset.
    """
    model, u = world(CASES["speed-weakening"], generator(20050, "speed-weakening", w))
    found = sample(model, n_chains=2, n_draws=250, seed=w)
    draws = found.draws
    assert np.all(np.abs(draws.mean(axis=0) - u) < 4.0 * draws.std(axis=0))
    star, some = found.posterior, (draws.mean(axis=0), *draws[::25])
    off = [star.log_likelihood(v) - star.exact_log_likelihood(v) for v in some]
    assert np.sqrt(np.mean(np.square(off))) < 2.5


@pytest.mark.slow
def test_a_fault_of_the_model_is_seen() -> None:
    names, ranks, _ = _ranks("volume-scatter", 60, fault=3.0)
    assert least_p(names, ranks) < LEVEL


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_ranks_are_uniform(name: str) -> None:
    names, ranks, left = _ranks(name, CASES[name].n_worlds)
    print(name, f"left {left:.2f}")
    assert left > 0.02, "events that leave the profile belong to the test"
    assert least_p(names, ranks) > LEVEL
