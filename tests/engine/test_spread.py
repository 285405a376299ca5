"""The engines: the same bits by each, in order, few items under way, and after a death."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.engine import set_engine, spread_map
from avahazard.records.errors import AvahazardError
from tests.engine import work

pytestmark = pytest.mark.usefixtures("default_engine")

N = 24


@pytest.fixture(scope="module")
def alone() -> bytes:
    return np.array([work.draws(3, item) for item in range(N)]).tobytes()


@pytest.mark.parametrize("workers", [1, 2, 7])
def test_threads_give_the_same_bits(workers: int, alone: bytes) -> None:
    set_engine("local", workers=workers)
    assert np.array(list(spread_map(work.draws, 3, range(N)))).tobytes() == alone


def test_processes_give_the_same_bits_also_when_one_is_killed(alone: bytes, tmp_path: Path) -> None:
    set_engine("processes", workers=2)
    assert np.array(list(spread_map(work.draws, 3, range(N)))).tobytes() == alone
    seen = set(spread_map(work.inside, None, range(8)))
    assert os.getpid() not in {process for process, _ in seen}
    assert {n for _, n in seen} == {1}
    found = list(spread_map(work.draws_or_death, (3, tmp_path), range(N)))
    assert (tmp_path / "killed").exists()
    assert np.array(found).tobytes() == alone


def test_functions_made_inside_functions_reach_a_process() -> None:
    set_engine("processes", workers=1)
    factor = 3
    assert list(spread_map(lambda shared, k: factor * shared * k, 2, range(4))) == [0, 6, 12, 18]
    # As the effects of a user's file are made.
    module: dict[str, Any] = {"__name__": "effect_file"}
    exec("import math\ndef root(shared, k):\n    return math.sqrt(shared * k)", module)
    assert list(spread_map(module["root"], 4.0, [1, 4])) == [2.0, 4.0]


@pytest.mark.parametrize("engine", ["local", "processes"])
def test_an_error_reaches_the_caller(engine: str) -> None:
    set_engine(engine, workers=2)  # type: ignore[arg-type]
    with pytest.raises(ZeroDivisionError):
        list(spread_map(work.discontinuous, None, range(8)))


@pytest.mark.slow
def test_work_that_kills_every_process_is_given_up() -> None:
    set_engine("processes", workers=1)
    with pytest.raises(AvahazardError, match="ended 4 times"):
        list(spread_map(work.always_death, None, range(2)))


@pytest.mark.parametrize("engine", ["local", "processes"])
def test_few_items_are_taken_ahead(engine: str) -> None:
    set_engine(engine, workers=2)  # type: ignore[arg-type]
    taken: list[int] = []
    results = spread_map(work.draws, 3, work.counted(200, taken))
    next(results)
    assert len(taken) <= 10
    assert len(list(results)) == 199


def test_what_threads_must_not_share_is_done_one_after_the_other() -> None:
    set_engine("local", workers=3)
    taken: list[int] = []
    next(spread_map(work.draws, 3, work.counted(9, taken), threads=False))
    assert taken == [0]


def test_a_scheduler_is_for_dask_only() -> None:
    with pytest.raises(AvahazardError, match="no scheduler"):
        set_engine("processes", scheduler="tcp://127.0.0.1:8786")
