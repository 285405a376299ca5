"""Grids made fine enough about a mode."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from avahazard.inference.fitting.mode import find_mode
from avahazard.inference.fitting.mode_search import search_mode
from avahazard.inference.fitting.refinement import (
    TOLERANCE,
    _too_coarse,
    continued,
    refined,
    settled,
    sharpened,
)
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import Slot
from avahazard.inference.model.observations import build_observations
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from tests.inference.studies import observations, one_path, posterior


def _model(*effects: str) -> Posterior:
    return posterior(build_observations(one_path(40, seed=2, cut_m=1700.0)), *effects)


def _with_speeds(*effects: str) -> Posterior:
    """Tracks of speeds of every event: between two grid points the likelihood falls by hundreds."""
    records, _ = make_world(41_002, 60, 5, {"turbulent-drag": 1.0}, Settings(speeds=1.0))
    return posterior(build_observations(records), *effects)


def test_grids_are_refined_where_they_are_too_coarse() -> None:
    model = _model("turbulent-drag")
    mode = find_mode(model)
    k = model.layout.tables[0]
    fine = refined(model, mode)
    sd = float(np.sqrt(mode.covariance[k, k]))
    grid = np.array(fine.layout.slots[k].grid)
    coarse = np.array(model.layout.slots[k].grid)
    near = (coarse[1:] > mode.u[k] - 2 * sd) & (coarse[:-1] < mode.u[k] + 2 * sd)
    if np.max(np.diff(coarse)[near]) <= sd:
        assert fine is model
    else:
        assert np.diff(grid).max() <= sd * 1.0001
        assert grid[0] == pytest.approx(max(0.0, mode.u[k] - 6 * sd))
        assert grid[-1] == pytest.approx(min(coarse[-1], mode.u[k] + 6 * sd))


def test_grids_go_on_where_draws_gather_at_an_edge_of_theirs() -> None:
    model = _model("turbulent-drag")
    k = model.layout.tables[0]
    whole = model.layout.slots[k]
    points = np.linspace(0.3, 0.5, 6) * whole.high
    fine = model.regridded({whole.name: tuple(points)})
    draws = np.zeros((2, 100, len(model.layout.slots)))
    draws[..., k] = np.linspace(points[1], points[-2], 100)
    assert continued(fine, model, draws) is None
    draws[0, :, k] = points[-1]
    wider = continued(fine, model, draws)
    assert wider is not None
    # By its own length in its own steps, on that side alone.
    np.testing.assert_allclose(
        wider.layout.slots[k].grid, np.linspace(0.3, 0.7, 11) * whole.high, rtol=1e-12
    )
    draws[1, :, k] = points[0]
    both = continued(fine, model, draws)
    assert both is not None
    assert both.layout.slots[k].low == pytest.approx(0.1 * whole.high)
    # The edge of the range itself is no edge of the grid alone.
    ends = model.regridded({whole.name: tuple(np.linspace(0.8, 1.0, 4) * whole.high)})
    draws[..., k] = whole.high
    assert continued(ends, model, draws) is None
    beyond = model.regridded({whole.name: tuple(np.linspace(0.5, 0.9, 4) * whole.high)})
    draws[..., k] = 0.9 * whole.high
    last = continued(beyond, model, draws)
    assert last is not None
    assert last.layout.slots[k].high == whole.high


def test_without_tables_to_shape_nothing_is_refined() -> None:
    model = _model()
    assert refined(model, find_mode(model)) is model


def test_refining_keeps_the_part_of_the_events() -> None:
    model = posterior(observations(speeds=False), "epoch-bias")
    keep = np.arange(model.observations.n_events) % 2 == 0
    part = model.restricted(keep)
    fine = refined(part, find_mode(part))
    assert fine is not part
    u = find_mode(fine).u
    assert fine.log_likelihood(u) == pytest.approx(fine.event_log_likelihood(u)[keep].sum())


def test_a_blend_that_holds_is_left_alone() -> None:
    model = _model("turbulent-drag")
    mode = find_mode(model)
    assert model.exact_log_likelihood(mode.u) == pytest.approx(
        model.log_likelihood(mode.u), abs=TOLERANCE
    )
    assert settled(model, mode) == (model, mode)


class Errs:
    """Interpolation that errs by so much along each grid that has no point at u."""

    def __init__(self, errors: tuple[float, ...], grids: dict[str, tuple[float, ...]]) -> None:
        self.errors, self.grids = errors, grids
        slots = [Slot(name, "", 0.0, 1.0, grid=grid) for name, grid in grids.items()]
        self.layout = SimpleNamespace(slots=slots)

    def regridded(self, grids: dict[str, tuple[float, ...]]) -> Errs:
        return Errs(self.errors, self.grids | grids)

    def log_likelihood(self, u: np.ndarray) -> float:
        told = zip(self.errors, self.grids.values(), u, strict=True)
        return 5.0 + sum(e for e, grid, at in told if grid and at not in grid)


@pytest.mark.parametrize(
    ("errors", "coarse"),
    [((0.7, 9.0, -3.0), [0, 2]), ((0.1, 9.0, 3.0), [2]), ((0.4, 9.0, 0.3), [0])],
)
def test_only_grids_along_which_it_errs_are_split(
    errors: tuple[float, ...], coarse: list[int]
) -> None:
    model = Errs(errors, {"a": (0.0, 1.0, 2.0), "no grid": (), "b": (0.0, 1.0)})
    u = np.array([0.5, 7.0, 0.25])
    assert _too_coarse(model, u, 5.0) == coarse  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_peak_between_grid_points_that_is_none_is_found_out() -> None:
    model = _with_speeds("entrainment")
    rough = find_mode(model)
    # The climb ends where only the interpolation is high.
    assert model.log_likelihood(rough.u) - model.exact_log_likelihood(rough.u) > 3.0 * TOLERANCE
    fine, mode = settled(model, rough)
    exact = fine.exact_log_likelihood(mode.u)
    assert fine.log_likelihood(mode.u) == pytest.approx(exact, abs=TOLERANCE)
    assert exact > model.exact_log_likelihood(rough.u)
    for slot, whole in zip(fine.layout.slots, model.layout.slots, strict=True):
        assert (slot.low, slot.high) == (whole.low, whole.high)
        assert set(slot.grid) >= set(whole.grid)


@pytest.mark.slow
def test_the_truth_is_not_beaten_by_a_blend() -> None:
    """Drag made the world: entrainment, which is drag above a line, cannot explain more."""

    def highest(key: str) -> float:
        model, mode = sharpened(*search_mode(_with_speeds(key)))
        return model.exact_log_likelihood(mode.u)

    assert highest("entrainment") < highest("turbulent-drag") + 1.0
