"""The order of the files of tests."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from tests.conftest import ROOT
from tests.order import COMPILES, NO_KERNELS, ordered


def test_what_it_names_is_there() -> None:
    assert [name for name in (COMPILES, *NO_KERNELS) if not (ROOT / name).exists()] == []


def test_each_file_stays_whole_and_few_tests_come_first() -> None:
    ids = ["tests/a.py::x", "tests/a.py::y", "tests/b.py::z", f"{NO_KERNELS[0]}::v"]
    ids += [f"{COMPILES}::one", f"{COMPILES}::other"]
    given: list[Any] = [SimpleNamespace(nodeid=name) for name in ids]
    found = [item.nodeid for item in ordered(given)]
    assert found == [*ids[4:], ids[3], ids[2], ids[0], ids[1]]
