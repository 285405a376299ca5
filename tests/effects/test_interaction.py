"""Pairs of columns against products that are made event by event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import definition
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import FrictionEffect
from tests.effects.event_table import event_table

RNG = np.random.default_rng(4)
N = 60
COLD, WIND = RNG.standard_normal(N), 3.0 + 2.0 * RNG.standard_normal(N)
SNOW = [("dry", "wet", "mixed")[k] for k in RNG.choice(3, N, p=[0.5, 0.3, 0.2])]
DEEP = [("no", "yes")[k] for k in RNG.integers(0, 2, N)]


def table() -> EventColumns:
    found = event_table(cold=COLD.tolist(), wind=WIND.tolist(), snow=SNOW, deep=DEEP)
    return replace(found, log_volume=np.log(1e4) + np.linspace(-2.0, 2.0, N))


def effect(pair: str) -> FrictionEffect:
    entry = definition(f"interaction:{pair}")
    assert entry.lacking(table(), ()) is None
    built = entry.build(entry.facts(table(), ()))
    assert isinstance(built, FrictionEffect)
    return built


def spreads(values: np.ndarray) -> np.ndarray:
    return np.asarray((values - values.mean()) / values.std())


def test_two_numbers_and_their_product() -> None:
    made = effect("cold*wind")
    assert [p.name for p in made.parameters] == ["cold", "wind", "cold*wind"]
    cold, wind = spreads(COLD), spreads(WIND)
    expected = [[cold[i], wind[i], cold[i] * wind[i]] for i in range(N)]
    np.testing.assert_allclose(made.design(table()), expected)


def test_levels_beside_levels() -> None:
    made = effect("snow*deep")
    design = made.design(table())
    names = [p.name for p in made.parameters]
    others = sorted(set(SNOW) - {max(set(SNOW), key=SNOW.count)})
    (more,) = {"no", "yes"} - {max(sorted(set(DEEP)), key=DEEP.count)}
    assert names == [
        *(f"snow={level}" for level in others),
        f"deep={more}",
        *(f"snow={level}*deep={more}" for level in others),
    ]
    for i in range(N):
        assert design[i].tolist() == [
            *(float(SNOW[i] == level) for level in others),
            float(DEEP[i] == more),
            *(float(SNOW[i] == level and DEEP[i] == more) for level in others),
        ]


def test_of_many_levels_the_most_common_are_distinguished() -> None:
    counts = {"a": 5, "b": 6, "c": 7, "d": 8, "e": 9, "f": 25}
    assert sum(counts.values()) == N
    snow = [level for level, n in counts.items() for _ in range(n)]
    entry = definition("interaction:cold*snow")
    facts = entry.facts(event_table(cold=COLD.tolist(), snow=snow), ())
    assert facts["snow"] == {"levels": ["b", "c", "d", "e"]}


def test_the_volume_is_in_the_law_already() -> None:
    made = effect("snow*volume_m3")
    # Beside levels a number acts as its smooth does: the limit beyond which it matters may be soft.
    entry = definition("covariate:volume_m3")
    smooth = entry.build(entry.facts(table(), ()))
    assert isinstance(smooth, FrictionEffect)
    bends = ["volume_m3", *(f"volume_m3.bend_{k}" for k in (1, 2, 3))]
    of_volume = dict(zip(bends, smooth.design(table()).T, strict=True))
    np.testing.assert_allclose(of_volume["volume_m3"], spreads(table().log_volume))
    names = [p.name for p in made.parameters]
    for i in range(N):
        expected = {}
        for name in names:
            level, _, number = name.partition("*")
            size = of_volume[number][i] if number else 1.0
            expected[name] = size * (SNOW[i] == level.removeprefix("snow="))
        assert dict(zip(names, made.design(table())[i], strict=True)) == pytest.approx(expected)
    assert "volume_m3" not in names
    assert definition("interaction:snow*volume_m3").uses_volume
    assert not definition("interaction:snow*deep").uses_volume


def test_a_missing_value_counts_as_usual_and_a_missing_column_as_nothing() -> None:
    made = effect("cold*wind")
    gappy = event_table(cold=[np.nan, *COLD[1:]], wind=WIND.tolist())
    assert made.design(gappy)[0].tolist() == [0.0, spreads(WIND)[0], 0.0]
    bare = event_table(other=COLD.tolist())
    np.testing.assert_array_equal(made.design(bare), np.zeros((N, 3)))


def test_columns_that_say_the_same_are_no_pair() -> None:
    alike = event_table(snow=SNOW, kind=[level.upper() for level in SNOW])
    found = definition("interaction:snow*kind").lacking(alike, ())
    assert found == "snow and kind do not vary apart from each other"
    bare = event_table(snow=SNOW, kind=["one"] * N)
    found = definition("interaction:snow*kind").lacking(bare, ())
    assert found == "kind has no two values with at least 5 events each"


def in_region(change: float) -> EventColumns:
    """H/L is another where it is cold and the wind blows, and scatters."""
    cold, wind = np.quantile(COLD, 0.5), np.quantile(WIND, 0.5)
    there = (cold < COLD) & (wind > WIND)
    ratio = np.exp(-0.8 + change * there + 0.05 * RNG.standard_normal(N))
    return replace(table(), height_over_length=ratio)


def test_one_change_where_both_are_beyond_a_limit() -> None:
    columns = in_region(0.4)
    entry = definition("interaction:cold*wind")
    made = entry.build(entry.facts(columns, ()))
    assert isinstance(made, FrictionEffect)
    (parameter,) = made.parameters
    cold, wind = (float(part[5:]) for part in parameter.name.split("*"))
    assert parameter.name == f"cold>{cold:.4g}*wind<{wind:.4g}"
    there = [float(COLD[i] > cold and WIND[i] < wind) for i in range(N)]
    assert made.design(columns)[:, 0].tolist() == there
    true = (np.median(COLD) < COLD) & (np.median(WIND) > WIND)
    assert np.mean(true == np.array(there)) >= 0.95
    seen = entry.seen_in(columns, ())
    assert str(seen) == (
        f"Friction differs where {parameter.name.replace('*', ' and ')} "
        f"({int(sum(there))} of 60 events)."
    )
    # What is missing lies in no region.
    gappy = replace(columns, numbers={**columns.numbers, "cold": np.full(N, np.nan)})
    assert not made.design(gappy).any()


def test_a_line_in_one_column_where_the_other_is_beyond_a_limit() -> None:
    for along, line, name, other in (("cold", COLD, "wind", WIND), ("wind", WIND, "cold", COLD)):
        there = np.quantile(other, 0.6) < other
        noise = 0.05 * RNG.standard_normal(N)
        ratio = np.exp(-0.8 + np.where(there, 0.1 + 0.25 * spreads(line), 0.0) + noise)
        columns = replace(table(), height_over_length=ratio)
        entry = definition("interaction:cold*wind")
        made = entry.build(entry.facts(columns, ()))
        assert isinstance(made, FrictionEffect)
        level, slope = made.parameters
        assert slope.name == f"{along}*{level.name}"
        assert level.name.startswith(f"{name}>")
        design = made.design(columns)
        assert np.mean(there == design[:, 0]) >= 0.95
        expected = np.where(design[:, 0] > 0.0, spreads(line), 0.0)
        np.testing.assert_allclose(design[:, 1], expected)
        seen = f"Friction varies with {along} where {level.name} ({int(design[:, 0].sum())} of 60"
        assert str(entry.seen_in(columns, ())).startswith(seen)


def test_a_limit_of_one_column_is_no_pair() -> None:
    there = np.quantile(WIND, 0.6) < WIND
    ratio = np.exp(-0.8 + 0.3 * there + 0.05 * RNG.standard_normal(N))
    columns = replace(table(), height_over_length=ratio)
    assert "region" not in definition("interaction:cold*wind").facts(columns, ())


def test_a_product_is_no_region() -> None:
    noise = 0.05 * RNG.standard_normal(N)
    ratio = np.exp(-0.8 + 0.2 * spreads(COLD) * spreads(WIND) + noise)
    columns = replace(table(), height_over_length=ratio)
    entry = definition("interaction:cold*wind")
    assert "region" not in entry.facts(columns, ())
    assert entry.seen_in(columns, ()) is None


def test_every_region_has_enough_events_in_it_and_beside_it() -> None:
    for pair in ("cold*wind", "snow*wind", "snow*volume_m3"):
        entry = definition(f"interaction:{pair}")
        assert entry.alternatives is not None
        product, *regions = entry.alternatives(in_region(0.1), ())
        assert "region" not in product
        assert 1 < len(regions) <= 48
        designs = [entry.build(facts).design(table())[:, 0] for facts in regions]  # type: ignore[attr-defined]
        assert all(10 <= design.sum() <= N - 10 for design in designs)
        assert len({design.tobytes() for design in designs}) == len(designs)
    names = {p.name for facts in regions for p in entry.build(facts).parameters}
    volume = np.exp(np.quantile(table().log_volume, 0.5))
    assert f"snow=dry*volume_m3<{volume:.4g}" in names


def on_paths(acts: Sequence[int], text: bool = False) -> EventColumns:
    """240 events on 6 paths; on some of these friction falls with the cold, or is low if wet."""
    rng, path = np.random.default_rng(8), np.arange(240) % 6
    cold, wet = rng.standard_normal(240), rng.uniform(size=240) < 0.4
    found = event_table(cold=cold.tolist(), snow=np.where(wet, "wet", "dry").tolist())
    there = np.isin(path, acts)
    change = -0.3 * wet if text else -0.15 * cold
    ratio = np.exp(-0.8 + 0.05 * path + there * change + 0.1 * rng.standard_normal(240))
    names = tuple(f"P{k}" for k in range(6))
    return replace(found, paths=names, path_index=path, height_over_length=ratio)


@pytest.mark.parametrize("acts", [(2, 5), (0, 1, 2, 3, 4, 5)])
def test_a_column_acts_on_some_paths(acts: tuple[int, ...]) -> None:
    columns, entry = on_paths(acts), definition("interaction:cold*path_id")
    assert entry.lacking(columns, ()) is None
    made = entry.build(entry.facts(columns, ()))
    assert isinstance(made, FrictionEffect)
    assert list(made.paths) == [f"P{k}" for k in acts]
    assert [p.name for p in made.parameters] == [f"cold*path_id=P{k}" for k in acts]
    cold = spreads(columns.numbers["cold"])
    expected = np.column_stack([cold * (columns.path_index == k) for k in acts])
    np.testing.assert_allclose(made.design(columns), expected)
    note = entry.seen_in(columns, ())
    assert note is not None
    assert note.startswith("Friction varies with cold on P")


def test_a_level_acts_on_some_paths() -> None:
    columns, entry = on_paths((1, 3), text=True), definition("interaction:snow*path_id")
    made = entry.build(entry.facts(columns, ()))
    assert isinstance(made, FrictionEffect)
    assert [p.name for p in made.parameters] == [f"snow=wet*path_id=P{k}" for k in (1, 3)]
    wet = columns.texts["snow"] == "wet"
    expected = np.column_stack([wet & (columns.path_index == k) for k in (1, 3)])
    assert np.array_equal(made.design(columns), expected)


def test_what_is_the_same_along_a_path_does_not_depend_on_the_path() -> None:
    columns = on_paths((2,))
    of_path = replace(columns, numbers={"area": columns.path_index.astype(float)})
    lacks = definition("interaction:area*path_id").lacking(of_path, ())
    assert lacks == "area and path_id do not vary apart from each other"
