"""Paths made ready to run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.site import (
    StopTable,
    build_site,
    path_site,
    release_place,
    release_places,
    stop_table,
)
from avahazard.physics.block import NOT_RELEASED, STOPPED, run
from avahazard.physics.cells import build_cells, no_resistance
from avahazard.physics.runout_curve import MU
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Profile, Simulation
from tests.workflow.worlds import bowl, height

X = np.linspace(0.0, 1900.1234567, 96)
Y = 1000.0 - 0.8 * X + 2e-4 * X**2


def _profile(land_cover: tuple[str, ...] | None = None) -> Profile:
    return Profile("B", X, Y, land_cover)


def _site(releases: list[float], land_cover: tuple[str, ...] | None = None):
    return build_site(Path("B"), _profile(land_cover), smooth_profile(X, Y), releases)


@pytest.mark.parametrize("elevation", [950.0, 700.0, 400.0])
def test_the_release_is_where_the_path_has_its_elevation(elevation: float) -> None:
    smooth = smooth_profile(X, Y)
    place = release_place(smooth, elevation)
    assert smooth.height(place) == pytest.approx(elevation, abs=1e-5)
    assert place == round(place, 6)


def test_releases_outside_the_path_are_moved_to_its_ends() -> None:
    smooth = smooth_profile(X, Y)
    assert release_place(smooth, None) == smooth.x_min
    assert release_place(smooth, 5000.0) == smooth.x_min
    assert release_place(smooth, 0.0) == pytest.approx(smooth.x_max)
    end = float(smooth.height(smooth.x_max))
    for elevation in (end, end + 1e-9, end - 1e-9):
        assert release_place(smooth, elevation) <= smooth.x_max


def test_the_first_of_two_places_with_one_elevation() -> None:
    x = np.linspace(0.0, 3000.0, 151)
    smooth = smooth_profile(x, 1000.0 - 0.8 * x + 2e-4 * x**2)
    assert release_place(smooth, 300.0) < 1500.0


def test_many_places_at_once_are_those_of_each() -> None:
    smooth = smooth_profile(X, Y + 30.0 * np.sin(X / 90.0))
    wanted = [None, 5000.0, 0.0, float(Y[0]), 950.0, 700.0, 400.0, float(Y[-1])]
    assert release_places(smooth, wanted) == [release_place(smooth, z) for z in wanted]
    assert release_places(smooth, []) == []


def test_releases_are_nodes_once_each_and_in_order() -> None:
    site = _site([300.25, 0.0, 300.25, 77.7])
    assert site.release_x.tolist() == [0.0, 77.7, 300.25]
    for terrain in (site.terrain, site.fine_terrain):
        assert [terrain.x[terrain.node(x)] for x in site.release_x] == site.release_x.tolist()
    assert site.fine_terrain.n_cells > 1.5 * site.terrain.n_cells


def test_cover_is_that_of_the_point_before_and_changes_at_nodes() -> None:
    names = np.where(X < 600.0, "open", np.where(X < 1100.0, "forest", "rock"))
    site = _site([0.0], tuple(names.tolist()))
    for terrain in (site.terrain, site.fine_terrain):
        cover = site.cover(terrain.middle_x)
        slow = [names[max(i for i in range(len(X)) if X[i] <= x)] for x in terrain.middle_x]
        assert cover.tolist() == slow
        edges = X[np.flatnonzero(names[1:] != names[:-1]) + 1]
        assert np.isin(edges, terrain.x).all()


def test_without_cover_all_is_open() -> None:
    site = _site([0.0])
    assert site.cover(np.array([-1.0, 5.0])).tolist() == ["open", "open"]


def test_the_table_has_a_row_for_every_release() -> None:
    site = _site([0.0, 300.25])
    table = site.table(site.cells(no_resistance(site.terrain)))
    cells = build_cells(site.terrain, no_resistance(site.terrain))
    for row, release in enumerate(site.release_x):
        stops = run(cells, np.array([site.terrain.node(release)]), MU)
        assert np.array_equal(table.x[row], stops.x[0], equal_nan=True)
        assert np.array_equal(table.status[row], stops.status[0])


def test_a_fine_resistance_runs_over_fine_cells() -> None:
    site = _site([0.0, 300.25])
    coarse, fine = no_resistance(site.terrain), no_resistance(site.fine_terrain)
    assert site.terrain_for(coarse) is site.terrain
    assert site.terrain_for(fine) is site.fine_terrain
    one, other = site.table(site.cells(coarse)), site.table(site.cells(fine))
    both = (one.status == STOPPED) & (other.status == STOPPED)
    assert both.sum() > 100
    assert one.x[both] == pytest.approx(other.x[both], abs=0.01)


def test_a_release_at_the_end_goes_nowhere() -> None:
    site = _site([X[-1]])
    table = site.table(site.cells(no_resistance(site.terrain)))
    assert (table.status == NOT_RELEASED).all()


def test_a_path_runs_from_its_own_release_or_its_top() -> None:
    records = bowl()
    (path,), (profile,) = records.paths, records.profiles
    assert path_site(path, profile).release_x[0] == 0.0
    lower = replace(path, release_elevation_m=800.0)
    release = path_site(lower, profile).release_x[0]
    assert height(release) == pytest.approx(800.0, abs=1.0)


def _run(friction: float, volume: float, stop: float, *, left: bool = False) -> Simulation:
    return Simulation("P", "com1dfa", "", friction, volume, 0.0, stop, left, 1.0)


def _table() -> StopTable:
    runs = [
        _run(0.2, 1e3, 900.0),
        _run(0.4, 1e3, 500.0),
        _run(0.2, 1e5, 1000.0, left=True),
        _run(0.4, 1e5, 700.0),
        _run(0.6, 1e5, np.nan),
    ]
    return stop_table(runs, 100.0, 1000.0)


def test_friction_goes_straight_in_places_and_log_volume() -> None:
    table = _table()
    assert table.at(1e3, np.array([0.2, 0.3, 0.4])) == pytest.approx([900.0, 700.0, 500.0])
    assert table.at(1e4, np.array([0.4])) == pytest.approx([580.0])
    assert table.at(1e5, np.array([0.5, 0.6])) == pytest.approx([400.0, 100.0])  # did not move


def test_what_passes_the_end_has_left_and_the_ends_of_the_table_count_beyond_it() -> None:
    table = _table()
    assert table.at(1e5, np.array([0.2]))[0] == np.inf
    assert table.at(1e7, np.array([0.4])) == pytest.approx([700.0])
    assert table.at(1e3, np.array([0.1, 0.9])) == pytest.approx([900.0, 500.0])


def test_more_friction_never_carries_farther() -> None:
    table = stop_table([_run(0.2, 1e3, 500.0), _run(0.3, 1e3, 510.0)], 0.0, 1000.0)
    assert table.at(1e3, np.array([0.2, 0.3])) == pytest.approx([510.0, 510.0])
