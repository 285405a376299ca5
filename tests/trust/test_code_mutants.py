"""Small changes of the code: which are made, which are drawn, which tests they are tried on."""

from __future__ import annotations

import ast
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from benchmarks.trust.code_changes import Change, changed, changes_of, names_in_kernels
from benchmarks.trust.code_mutants import (
    ELSEWHERE,
    ROOT,
    TESTED,
    UNCOMPILED,
    Covered,
    all_changes,
    sampled,
    tried,
)
from benchmarks.trust.code_section import READ, code, name_of

SOURCE = '''
"""Words of 3 pages."""
BASE = 2
LIMIT = BASE
OTHER = 4


@kernel(forceinline=True)
def climb(x: "Floats[3]", far=False):
    """Words 1 + 1."""
    if x < LIMIT and not far:
        raise ValueError("it is " + 5)
    for k in range(9):
        x *= -k
        if far:
            break
    out.append(max(x, "1"))
    return f"{x + 1:.3f}"
'''
MADE = {
    "2 → 3",
    "4 → 5",
    "False → True",
    "x < LIMIT → x <= LIMIT",
    "x < LIMIT → x >= LIMIT",
    "x < LIMIT and (not far) → x < LIMIT or not far",
    "not far → far",
    "9 → 10",
    "x *= -k → x /= -k",
    "x *= -k → x = -k",
    "-k → k",
    "far → not far",
    "break → continue",
    "out.append(max(x, '1')) → pass",
    "max → min",
    "x + 1 → x - 1",
    "1 → 2",
}


def test_all_changes_of_a_source() -> None:
    made = changes_of("m.py", SOURCE, names_in_kernels([SOURCE]))
    assert {change.what for change in made} == MADE
    assert [change.what for change in made if not change.compiled] == ["4 → 5"]
    assert {change.where for change in made} == {"", "climb"}


def test_a_change_is_made_alone() -> None:
    right = ast.unparse(ast.parse(SOURCE)).splitlines()
    for change in changes_of("m.py", SOURCE):
        lines = ast.unparse(changed(SOURCE, change.number)).splitlines()
        assert sum(a != b for a, b in zip(right, lines, strict=True)) == 1, change
        compile(changed(SOURCE, change.number), "m.py", "exec")


def test_the_sample_is_as_dense_in_each_module() -> None:
    changes = [
        Change(f"{name}.py", k, 1, "f", "", False)
        for name, n in (("a", 300), ("b", 30), ("c", 60))
        for k in range(n)
    ]
    drawn = sampled(changes, 39, np.random.default_rng(1))
    counts = Counter(change.module for change in drawn)
    assert counts["a.py"] in (29, 30, 31)
    assert (2, 5) <= (counts["b.py"], counts["c.py"]) <= (4, 7)
    assert len({(change.module, change.number) for change in drawn}) == 39
    assert len(sampled(changes, 1000, np.random.default_rng(1))) == 390


def test_the_tests_of_a_line_are_those_that_run_it_its_own_file_first() -> None:
    covered = Covered(
        {"t/test_m.py::a": 5.0, "t/test_m.py::b": 2.0, "t/test_n.py::c": 1.0, "t/test_n.py::d": 40},
        {"m.py": {1: [""], 4: ["t/test_m.py::a", "t/test_n.py"], 9: ["t/test_m.py::b"]}},
    )

    def tests(line: int, where: str = "f") -> list[str]:
        return covered.tests_of(Change("m.py", 0, line, where, "", False))

    assert tests(4) == ["t/test_m.py::a", "t/test_n.py::c"]  # d would take too long
    assert tests(6) == tests(4)
    assert tests(9) == ["t/test_m.py::b"]
    assert set(tests(1)) == {"t/test_m.py::a", "t/test_m.py::b", "t/test_n.py::c"}
    assert covered.tests_of(Change("other.py", 0, 3, "f", "", False)) == []


def test_the_tests_of_kernels_are_there() -> None:
    assert [file for file in UNCOMPILED if not (ROOT / file).is_file()] == []


@pytest.mark.slow
def test_a_wrong_line_is_seen_and_the_right_code_is_not_at_fault() -> None:
    (gravity,) = (c for c in all_changes() if c.module == "avahazard/physics/constants.py")
    name = "tests/physics/test_block.py::test_cohesion_also_holds_the_block"
    covered = Covered({name: 9.0}, {gravity.module: {0: [name]}})
    # The first is tried on the true code too, which must not fail.
    found = list(tried([gravity], covered, compiled=False))
    assert [(change, ended) for change, ended, _ in found] == [(gravity, "killed")]


def test_the_page_counts_and_says_what_reading_them_gave() -> None:
    survivor = {"place": "avahazard/physics/x.py:7", "where": "f", "what": "a | b → a", "ended": ""}
    assert name_of(survivor) == "physics/x.py f: a | b → a"
    row = {"part": "physics", "changes": 90, "tried": 20, "killed": 18, "too long": 1}
    lines = code({"amounts": {"changes": 20, "seed": 1}, "rows": [row], "survivors": [survivor]})
    assert "| physics | 90 | 20 | 18 | 1 | 90% |" in lines
    assert "- `physics/x.py:7` `a | b → a`: not read yet" in lines
    assert any("not read yet" in line for line in lines if line.startswith("In all 18 of 20"))


def test_the_score_leaves_out_what_reading_called_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    survivors = [
        {"place": f"avahazard/physics/{name}.py:7", "where": "f", "what": "a → b", "ended": ""}
        for name in ("x", "y")
    ]
    said = dict(zip(map(name_of, survivors), ("the same: why", "a hole"), strict=True))
    read = tmp_path / READ.name
    read.write_text(json.dumps(said), encoding="utf-8")
    monkeypatch.setattr("benchmarks.trust.code_section.READ", read)
    row = {"part": "physics", "changes": 90, "tried": 20, "killed": 18, "too long": 1}
    lines = code({"amounts": {"changes": 20, "seed": 1}, "rows": [row], "survivors": survivors})
    assert any("18 of 20 are killed: 90.0%" in line and "18 of 19, 94.7%" in line for line in lines)


def test_the_tests_elsewhere_are_there_and_others_than_those_of_the_parts() -> None:
    assert [folder for folder in ELSEWHERE if not (ROOT / folder).is_dir()] == []
    parts = [tests for _, tests in TESTED.values()]
    assert [one for one in ELSEWHERE if any(part.startswith(one) for part in parts)] == []
