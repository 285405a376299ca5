"""A change at a date: which dates are tried, which is chosen, and whom it concerns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.change import MOST_DATES
from avahazard.effects.columns import EventColumns, build_columns
from avahazard.effects.effect import MIN_LEVEL, FrictionEffect
from avahazard.records.collection import Event, Path
from avahazard.report.words import unit_text

N = 40
SINCE = 1979.4


def table(jump: float = 0.4, path: str = "P0", n: int = N) -> EventColumns:
    """One event a year from 1960 on, by turns on two paths; on one friction jumps."""
    rng = np.random.default_rng(2)
    events = [
        Event(f"e{k}", f"P{k % 2}", f"{1960 + k}-03-01", volume_m3=float(np.exp(9 + k % 3)))
        for k in range(n)
    ]
    after = np.array([e.path_id == path and 1960 + k > SINCE for k, e in enumerate(events)])
    ratio = np.exp(-0.8 + 0.3 * (np.arange(n) % 2) + jump * after + 0.05 * rng.standard_normal(n))
    paths = {name: Path(name) for name in ("P0", "P1")}
    return build_columns(events, paths, np.full(n, 900.0), ratio)


def built(key: str, columns: EventColumns) -> FrictionEffect:
    entry = definition(key)
    found = entry.build(entry.facts(columns, ()))
    assert isinstance(found, FrictionEffect)
    return found


def test_the_date_that_parts_friction_best_is_chosen() -> None:
    facts = definition("change:P0").facts(table(), ())
    # Between the winters of 1978 and 1980, the last before and the first after on that path.
    assert 1978.1 < facts["from_year"] < 1980.2
    (parameter,) = definition("change:P0").build(facts).parameters
    assert parameter.unit == f"log friction from {facts['from_year']:.1f} on"
    assert unit_text(parameter.unit).startswith("log friction from ")


def test_the_date_is_noted_with_the_events_on_either_side() -> None:
    columns = table()
    note = definition("change:P0").seen_in(columns, ())
    assert note is not None
    assert "before and after 1979.2 (10 and 10 events); the date lies between 1978." in note
    # A change that the records show plainly lies between two of them.
    assert 1978.1 < note.values["low"] < SINCE < note.values["high"] < 1980.2
    assert definition("change:P0").seen_in(table(n=6), ()) is None


def test_only_later_events_of_the_path_change() -> None:
    columns = table()
    design = built("change:P0", columns).design(columns)
    expected = [[float(k % 2 == 0 and 1960 + k > SINCE)] for k in range(N)]
    assert design.tolist() == expected
    everywhere = built("change:all", table(path="P1")).design(columns)
    years = 1960 + np.arange(N)
    assert everywhere[:, 0].tolist() == (years >= years[everywhere[:, 0] > 0.0][0]).tolist()


def test_what_has_no_date_is_to_come() -> None:
    made = built("change:P0", table())
    coming = [Event("a", "P0"), Event("b", "P1"), Event("c", "P0", "1961-02-01")]
    columns = build_columns(coming, {n: Path(n) for n in ("P0", "P1")}, np.full(3, 900.0))
    assert made.design(columns).tolist() == [[1.0], [0.0], [0.0]]


def test_dates_leave_enough_events_on_either_side() -> None:
    alternatives = definition("change:P1").alternatives
    assert alternatives is not None
    columns = table()
    tried = [facts["from_year"] for facts in alternatives(columns, ())]
    year = 1960.0 + np.arange(N)[columns.path_index == 1] + 60.0 / 365.0
    assert len(tried) == len(year) - 2 * MIN_LEVEL + 1
    for date in tried:
        assert min(np.sum(year < date), np.sum(year > date)) >= MIN_LEVEL
    many = definition("change:all").alternatives
    assert many is not None
    assert len(many(table(n=300), ())) == MOST_DATES


@pytest.mark.parametrize(("key", "n"), [("change:P0", 18), ("change:all", 9)])
def test_few_dated_events_have_no_date_of_change(key: str, n: int) -> None:
    assert definition(key).lacking(table(n=n), ()) == "fewer than 10 dated events"
    assert definition(key).lacking(table(n=n + 2), ()) is None
    undated = replace(table(), day=np.full(N, np.nan), year=np.full(N, np.nan))
    assert definition(key).lacking(undated, ()) == "fewer than 10 dated events"


def test_friction_of_some_years_is_another() -> None:
    years = np.arange(240) // 6
    rng = np.random.default_rng(6)
    events = [Event(f"e{k}", f"P{k % 6}", f"{1960 + y}-03-01") for k, y in enumerate(years)]
    inside = (years >= 12) & (years < 22)
    ratio = np.exp(-0.8 + 0.25 * inside + 0.1 * rng.standard_normal(240))
    paths = {f"P{k}": Path(f"P{k}") for k in range(6)}
    columns = build_columns(events, paths, np.full(240, 900.0), ratio)
    entry = definition("change:years")
    facts = entry.facts(columns, ())
    assert 1971.0 <= facts["from_year"] <= 1973.2
    assert 1981.0 <= facts["until_year"] <= 1983.2
    made = entry.build(facts)
    assert isinstance(made, FrictionEffect)
    (parameter,) = made.parameters
    span = f"from {facts['from_year']:.1f} to {facts['until_year']:.1f}"
    assert unit_text(parameter.unit) == f"log friction {span}"
    at = 1960.0 + years + 60.0 / 365.0
    expected = (at >= facts["from_year"]) & (at < facts["until_year"])
    assert np.array_equal(made.design(columns)[:, 0] > 0.0, expected)
    # What is to come is of no such year.
    coming = build_columns([Event("a", "P0")], paths, np.full(1, 900.0))
    assert made.design(coming).tolist() == [[0.0]]
    note = entry.seen_in(columns, ())
    assert note is not None
    assert span in note
    for end, low, high in (("year", "low", "high"), ("until", "first", "last")):
        assert note.values[low] < note.values[end] < note.values[high]
    assert entry.lacking(table(n=14), ()) == "fewer than 15 dated events"
    assert entry.lacking(table(n=16), ()) is None
    alternatives = entry.alternatives(columns, ()) if entry.alternatives else []
    assert len(alternatives) > 200
    assert all(a["until_year"] > a["from_year"] for a in alternatives)


def test_several_paths_change_by_amounts_of_their_own() -> None:
    years = np.arange(240) // 6
    rng = np.random.default_rng(5)
    events = [Event(f"e{k}", f"P{k % 6}", f"{1960 + y}-03-01") for k, y in enumerate(years)]
    on = np.isin(np.arange(240) % 6, [1, 4])
    ratio = np.exp(-0.8 + 0.3 * (on & (years >= 20)) + 0.1 * rng.standard_normal(240))
    paths = {name: Path(name) for name in ("P0", "P1", "P2", "P3", "P4", "P5")}
    columns = build_columns(events, paths, np.full(240, 900.0), ratio)
    entry = definition("change:several")
    facts = entry.facts(columns, ())
    assert facts["paths"] == ["P1", "P4"]
    made = entry.build(facts)
    assert isinstance(made, FrictionEffect)
    assert [p.name for p in made.parameters] == list(made.paths) == ["P1", "P4"]
    after = (years >= 20) & (np.abs(facts["from_year"] - 1980.0) < 1.0)
    expected = np.column_stack([(np.arange(240) % 6 == k) & after for k in (1, 4)])
    assert np.array_equal(made.design(columns), expected)
    note = entry.seen_in(columns, ())
    assert note is not None
    assert "On P1 and P4 the records differ most before and after" in note
    assert entry.alternatives is not None
    assert entry.alternatives(columns, ())[0]["paths"] == [f"P{k}" for k in range(6)]
    few = build_columns(events[:54], paths, np.full(54, 900.0), ratio[:54])
    assert entry.lacking(few, ()) == "fewer than 10 dated events on each of two paths"
