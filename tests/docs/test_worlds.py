"""The published worlds keep what the page promises, and the page is theirs."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import Any

import pytest

from benchmarks.study import lines as finished
from benchmarks.worlds.again import ALL_OF, comparison, one_of_each
from benchmarks.worlds.arms import FINAL_EFFECT, final_worlds, further_nulls, plans, settled_worlds
from benchmarks.worlds.counts import SEEN, alarm, first_alone, in_set, one_named
from benchmarks.worlds.page import page
from benchmarks.worlds.trap_tables import interval, is_trapped

ROOT = Path(__file__).resolve().parents[2]
SIZE = 20


@pytest.fixture(scope="module")
def lines() -> list[dict[str, Any]]:
    return finished(ROOT / "benchmarks" / "worlds.jsonl.gz")


def _share(lines: list[dict[str, Any]], is_so) -> float:  # type: ignore[no-untyped-def]
    return sum(bool(is_so(x)) for x in lines) / len(lines)


def _seen(lines: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Single effects of the catalogue that an oracle detects in the larger worlds."""
    return [
        x
        for x in lines
        if " x " in x["arm"] and x["n_events"] >= 200 and x.get("oracle_gain", 0.0) > SEEN
    ]


def test_the_page_is_written_from_these_results(lines: list[dict[str, Any]]) -> None:
    others = [
        finished(ROOT / "benchmarks" / f"worlds_{which}.jsonl")
        for which in ("again", "final", "settled")
    ]
    made = page(lines, f"make worlds SIZE={SIZE}", len(plans(SIZE)), *others)
    assert (ROOT / "docs" / "worlds.md").read_text(encoding="utf-8") == made


def test_there_are_300_nulls_and_each_arm_keeps_its_alarms(lines: list[dict[str, Any]]) -> None:
    nulls = [x for x in lines if x["arm"].startswith("null") and not is_trapped(x)]
    assert len(nulls) >= 300
    for arm in {x["arm"] for x in nulls}:
        assert _share([x for x in nulls if x["arm"] == arm], alarm) <= 0.07


def test_every_effect_has_ten_worlds_at_each_strength(lines: list[dict[str, Any]]) -> None:
    for arm in {p.arm for p in plans(SIZE) if " x " in p.arm}:
        assert sum(x["arm"] == arm for x in lines) >= 10


def test_effects_are_found_and_rivals_are_worse(lines: list[dict[str, Any]]) -> None:
    seen = _seen(lines)
    assert _share(seen, in_set) >= 0.95
    alone = _share(seen, first_alone)
    assert alone >= 0.85
    assert _share([x for x in seen if one_named(x)], first_alone) >= 0.95
    for rival in ("bic", "regression"):
        assert _share(seen, lambda x, who=rival: x[who] in x["true"]) < alone - 0.1


def test_errors_fall_to_the_oracles_and_intervals_cover(lines: list[dict[str, Any]]) -> None:
    seen = _seen(lines)
    assert median(x["child"][0] / x["oracle"][0] for x in seen if "oracle" in x) <= 1.05
    assert 0.87 <= sum(x["child"][1] for x in seen) / len(seen) <= 0.93
    wrong = [x["wrong"][0] / x["base"][0] for x in lines if "wrong" in x]
    assert median(wrong) >= 1.0


def test_what_is_confounded_is_named_once_it_is_measured(lines: list[dict[str, Any]]) -> None:
    for asked in ("with_speeds", "as_told"):
        again = [x for x in lines if asked in x]
        assert again
        assert _share(again, lambda x, key=asked: x[key][1] == x["true"]) >= 0.9


def test_outside_the_catalogue_the_axis_is_named(lines: list[dict[str, Any]]) -> None:
    outside = [
        x for x in lines if x["arm"].startswith("outside") and x.get("oracle_gain", 0.0) > SEEN
    ]
    assert _share(outside, in_set) >= 0.7
    assert (
        _share(outside, lambda x: any(not k.startswith("covariate:") for k in x["missing"])) <= 0.1
    )


@pytest.mark.parametrize("which", ["worlds.jsonl.gz", "worlds_final.jsonl"])
def test_traps_give_no_more_false_names_than_the_level_allows(which: str) -> None:
    lines = finished(ROOT / "benchmarks" / which)
    nulls = [x for x in lines if is_trapped(x) and not x["true"]]
    # Few worlds: 5 % must not be ruled out from below.
    assert interval(sum(map(alarm, nulls)), len(nulls))[0] <= 0.05


def test_limits_of_sight_are_found_as_settled_beforehand() -> None:
    lines = finished(ROOT / "benchmarks" / "worlds_settled.jsonl")
    assert {x["name"] for x in lines} == {p.name for p in settled_worlds(SIZE)}
    assert _share([x for x in lines if x["told_gain"] > SEEN], in_set) >= 0.9
    # Never called anything else.
    assert not any(alarm(x) for x in lines)


def test_intervals_of_shares_hold_their_share() -> None:
    assert interval(0, 20) == (0.0, pytest.approx(0.1684, abs=1e-4))
    assert interval(20, 20) == (pytest.approx(0.8316, abs=1e-4), 1.0)
    assert interval(3, 50) == (pytest.approx(0.0125, abs=1e-4), pytest.approx(0.1655, abs=1e-4))


def test_worlds_come_in_turn_and_trapped_ones_have_seeds_of_their_own() -> None:
    worlds = plans(SIZE)
    trapped = [p for p in worlds if is_trapped({"arm": p.arm})]
    assert len({p.seed for p in worlds}) == len(worlds)
    assert min(p.seed for p in trapped) >= 500_000
    # A run that is cut short has seen every arm about as often as it should.
    first = {p.arm for p in trapped[:16]}
    assert len(first) == 16


def test_final_worlds_are_the_same_with_seeds_of_their_own() -> None:
    final, further = final_worlds(SIZE), further_nulls()
    first = [p for p in plans(SIZE) if is_trapped({"arm": p.arm}) or p.true == (FINAL_EFFECT,)]
    assert {p.name for p in final} == {p.name for p in first}
    assert not {p.name for p in further} & {p.name for p in final}
    settled = settled_worlds(SIZE)
    assert {p.name for p in settled} < {p.name for p in final}
    seeds = [p.seed for p in (*final, *further, *settled)]
    # None of today's other worlds, nor of the final ones of an earlier version.
    assert not set(seeds) & {p.seed for p in plans(SIZE)}
    assert min(seeds) >= 800_000
    assert len(set(seeds)) == len(seeds)


def test_one_world_of_each_arm_is_asked_again_and_a_changed_answer_is_told() -> None:
    chosen = one_of_each(plans(SIZE))
    one = [p for p in chosen if not p.arm.startswith(ALL_OF)]
    assert len({p.arm for p in one}) == len(one) >= 54
    assert all(p.n_events == 120 for p in one if not p.arm.startswith("confounded"))
    assert [p for p in chosen if p not in one] == [
        p for p in plans(SIZE) if p.arm.startswith(ALL_OF)
    ]
    line = {"name": "x #1", "true": ["season"], "neutral": [], "verdict": "adequate", "missing": []}
    told = "\n".join(comparison([{**line, "missing": ["season"]}], [{**line, "oracle_gain": 8.3}]))
    assert "- x #1: adequate, nothing named; then `season` (oracle 8)" in told
    assert "| right effect named or in the set | 100 % (1/1) | 0 % (0/1) |" in told
