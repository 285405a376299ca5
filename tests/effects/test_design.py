"""Effects on friction: the columns that are added to its log."""

from __future__ import annotations

import numpy as np
import pytest

from avahazard.arrays import Floats
from avahazard.effects import path_effect, path_section, release_elevation, season, snow_type
from avahazard.effects.effect import Definition, FrictionEffect, GroupEffect
from avahazard.records.event import Event
from tests.effects.examples import N_PATHS, columns, sites


def _design(entry: Definition, table=None) -> Floats:
    """The design columns; what the effect takes from the data is from all the events."""
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, FrictionEffect)
    return effect.design(columns() if table is None else table)


def test_snow_types_are_told_from_the_most_common() -> None:
    entry, table = snow_type.DEFINITION, columns()
    facts = entry.facts(table, sites())
    assert facts == {"reference": "dry", "levels": ["mixed", "wet"], "prior_sd": 0.2}
    names = [p.name for p in entry.build(facts).parameters]
    assert names == ["mixed", "wet"]
    kinds = table.texts["snow_type"]
    expected = np.column_stack([kinds == "mixed", kinds == "wet"])
    assert np.array_equal(_design(entry), expected)


def test_a_level_not_seen_before_has_no_effect() -> None:
    new = columns((Event("n", "P0", covariates={"snow_type": "slush"}),))
    assert np.array_equal(_design(snow_type.DEFINITION, new), [[0.0, 0.0]])
    none = columns((Event("n", "P0"),))
    assert np.array_equal(_design(snow_type.DEFINITION, none), [[0.0, 0.0]])


def test_open_paths_are_told_from_channelled_ones() -> None:
    design = _design(path_section.DEFINITION)
    assert np.array_equal(design[:, 0], columns().path_index % 2 == 1)


def test_release_elevations_count_in_kilometres_from_2000_m() -> None:
    table = columns((Event("a", "P0"), Event("b", "P0")))
    table.release_elevation[:] = [2500.0, np.nan]
    assert _design(release_elevation.DEFINITION, table)[:, 0].tolist() == [0.5, 0.0]


def test_the_winter_is_a_parabola_about_its_middle() -> None:
    dates = ("1950-01-30", "1950-03-31", "1949-12-01", "1950")
    table = columns(tuple(Event(d, "P0", date=d) for d in dates))
    t = np.array([0.0, 1.0, -1.0, 0.0])
    assert _design(season.DEFINITION, table) == pytest.approx(np.column_stack([t, t**2]))


def test_each_path_has_its_group() -> None:
    effect = path_effect.DEFINITION.build({})
    assert isinstance(effect, GroupEffect)
    groups = effect.groups(columns())
    assert groups.index.tolist() == [i % N_PATHS for i in range(36)]
    assert (groups.names, groups.alone) == (columns().paths, False)
    assert path_effect.DEFINITION.lacking(columns(), sites()) is None


def test_four_paths_are_too_few() -> None:
    few = columns(tuple(Event(str(i), f"P{i % 4}") for i in range(20)))
    assert "4 paths" in str(path_effect.DEFINITION.lacking(few, sites()))
