"""The shared threads: order, number, and no nesting."""

from __future__ import annotations

import threading

import pytest

from avahazard.workers import n_workers, ordered_map, set_workers

pytestmark = pytest.mark.usefixtures("default_engine")


def test_results_come_in_the_order_of_the_items() -> None:
    set_workers(3)
    assert list(ordered_map(pow, range(40), [2] * 40)) == [k * k for k in range(40)]


def test_as_many_run_side_by_side_as_were_asked_for() -> None:
    set_workers(3)
    together = threading.Barrier(3, timeout=10.0)  # breaks unless three arrive
    assert sorted(ordered_map(lambda _: together.wait(), range(3))) == [0, 1, 2]


def test_the_threads_are_made_once() -> None:
    set_workers(2)
    names = {n for _ in range(5) for n in ordered_map(lambda _: threading.get_ident(), range(8))}
    assert len(names) <= 2


def test_inside_a_worker_all_runs_in_that_worker() -> None:
    set_workers(2)

    def inner(_: int) -> tuple[int, set[int]]:
        me = threading.get_ident()
        return n_workers(), {me, *ordered_map(lambda _: threading.get_ident(), range(4))}

    for n, threads in ordered_map(inner, range(6)):
        assert n == 1
        assert len(threads) == 1


def test_one_worker_is_the_caller_itself() -> None:
    set_workers(1)
    assert set(ordered_map(lambda _: threading.get_ident(), range(3))) == {threading.get_ident()}


def test_an_error_reaches_the_caller() -> None:
    set_workers(2)
    with pytest.raises(ZeroDivisionError):
        list(ordered_map(lambda k: 1 // k, [1, 0]))
