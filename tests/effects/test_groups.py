"""Groups of events that share an offset: winters and storms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects.columns import EventColumns, build_columns
from avahazard.effects.effect import Definition, FrictionEffect, GroupEffect, Groups
from avahazard.effects.groups import PATH_EFFECT, STORM_EFFECT, WINTER_EFFECT, one_path
from avahazard.records.collection import Event
from tests.effects.examples import N_PATHS, columns, paths, sites

DATES = ("1950-01-30", "1950-09-30", "1950-10-01", "1951", "1951-03-01", "1960-01", None)


def dated(*dates: str | None, towns: tuple[str, ...] = ("",)) -> EventColumns:
    """Events on these days, on paths of these towns in turn."""
    known = {k: replace(p, location=towns[int(k[1:]) % len(towns)]) for k, p in paths().items()}
    events = [Event(f"e{i}", f"P{i % 6}", date=day) for i, day in enumerate(dates)]
    return build_columns(events, known, np.full(len(events), 700.0))


def groups(entry: Definition, learnt: EventColumns, used: EventColumns | None = None) -> Groups:
    effect = entry.build(entry.facts(learnt, sites()))
    assert isinstance(effect, GroupEffect)
    return effect.groups(learnt if used is None else used)


def test_a_winter_goes_from_october_to_september() -> None:
    table = dated(*DATES)
    np.testing.assert_array_equal(table.winter, [1950, 1950, 1951, 1951, 1951, 1960, np.nan])
    found = groups(WINTER_EFFECT, table)
    assert found.names == ("winter:1950", "winter:1951")
    assert found.index.tolist() == [0, 0, 1, 1, 1, -1, -1]
    assert found.alone


def test_a_storm_is_counted_from_its_first_day() -> None:
    days = ("1950-02-01", "1950-02-03", "1950-02-04", "1950-02-05", "1950-02-08", "1950-03-01")
    found = groups(STORM_EFFECT, dated(*days, "1950", "1950"))
    assert found.names == ("storm:1950-02-01", "storm:1950-02-05")
    assert found.index.tolist() == [0, 0, 0, 1, 1, -1, -1, -1]


def test_a_storm_is_of_one_place() -> None:
    days = ("1950-02-01", "1950-02-01", "1950-02-02", "1950-02-02")
    found = groups(STORM_EFFECT, dated(*days, towns=("Here", "There")))
    assert found.names == ("storm:1950-02-01 Here", "storm:1950-02-01 There")
    assert found.index.tolist() == [0, 1, 0, 1]


def test_other_events_are_in_the_groups_that_were_learnt() -> None:
    learnt, used = (
        dated("1950-02-01", "1950-02-03"),
        dated("1950-02-04", "1950-02-09", "1950-02-09"),
    )
    assert groups(STORM_EFFECT, learnt, used).index.tolist() == [0, -1, -1]
    assert groups(WINTER_EFFECT, learnt, used).index.tolist() == [0, 0, 0]


def test_what_they_lack() -> None:
    few = dated(*(f"19{50 + k // 2}-02-01" for k in range(8)))
    many = dated(*(f"19{50 + k // 2}-02-01" for k in range(10)))
    for entry in (WINTER_EFFECT, STORM_EFFECT):
        assert "fewer than 5" in str(entry.lacking(few, sites()))
        assert entry.lacking(many, sites()) is None


def test_two_paths_may_differ_but_are_not_named() -> None:
    table = dated("1950", "1951")
    entry = PATH_EFFECT
    assert entry.nuisance is not None
    assert entry.nuisance(table, sites()) is None
    assert "2 paths" in str(entry.lacking(table, sites()))
    assert entry.nuisance(dated("1950"), sites()) == "there is one path"


def test_each_path_has_its_group() -> None:
    effect = PATH_EFFECT.build({})
    assert isinstance(effect, GroupEffect)
    groups = effect.groups(columns())
    assert groups.index.tolist() == [i % N_PATHS for i in range(36)]
    assert (groups.names, groups.alone) == (columns().paths, False)
    assert PATH_EFFECT.lacking(columns(), sites()) is None


def test_four_paths_are_too_few() -> None:
    few = columns(tuple(Event(str(i), f"P{i % 4}") for i in range(20)))
    assert "4 paths" in str(PATH_EFFECT.lacking(few, sites()))


def test_one_path_has_its_own_friction() -> None:
    entry = one_path("P1")
    effect = entry.build(entry.facts(columns(), sites()))
    assert isinstance(effect, FrictionEffect)
    assert effect.design(columns())[:, 0].tolist() == [float(i % N_PATHS == 1) for i in range(36)]
    assert effect.paths == ("P1",)
    assert entry.lacking(columns(), sites()) is None
    assert "0 of 36 events" in str(one_path("elsewhere").lacking(columns(), sites()))
