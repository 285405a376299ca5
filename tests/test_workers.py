"""The shared threads: order, number, and who helps."""

from __future__ import annotations

import threading
import time

import pytest

from avahazard.workers import n_workers, one_worker, ordered_map, set_workers

pytestmark = pytest.mark.usefixtures("default_engine")


def test_results_come_in_the_order_of_the_items() -> None:
    set_workers(3)
    assert list(ordered_map(pow, range(40), [2] * 40)) == [k * k for k in range(40)]


def test_each_result_comes_as_soon_as_those_before_it() -> None:
    set_workers(2)
    seen = threading.Event()
    results = ordered_map(lambda k: k == 0 or seen.wait(10.0), range(2))
    assert next(results)
    seen.set()
    assert next(results)


def test_as_many_run_side_by_side_as_were_asked_for() -> None:
    set_workers(3)
    together = threading.Barrier(3, timeout=10.0)  # breaks unless three arrive
    assert sorted(ordered_map(lambda _: together.wait(), range(3))) == [0, 1, 2]


def test_the_threads_are_made_once() -> None:
    set_workers(2)
    names = {n for _ in range(5) for n in ordered_map(lambda _: threading.get_ident(), range(8))}
    assert len(names) <= 2


def test_a_worker_that_is_idle_helps_inside_another() -> None:
    set_workers(2)
    together = threading.Barrier(2, timeout=10.0)  # breaks unless two arrive

    def inner(k: int) -> list[int]:
        return [] if k else sorted(ordered_map(lambda _: together.wait(), range(2)))

    assert list(ordered_map(inner, range(2))) == [[0, 1], []]


def test_no_more_run_than_workers_however_deep_they_share() -> None:
    set_workers(2)
    at_work, most = set[int](), [0]

    def leaf(_: int) -> None:
        at_work.add(threading.get_ident())
        time.sleep(1e-3)
        most[0] = max(most[0], len(at_work))
        at_work.discard(threading.get_ident())

    def inner(_: int) -> None:
        list(ordered_map(leaf, range(4)))

    list(ordered_map(lambda _: list(ordered_map(inner, range(4))), range(4)))
    assert most[0] == 2


def test_the_worker_of_another_process_does_all_by_itself() -> None:
    set_workers(2)
    with one_worker():
        assert n_workers() == 1
        assert {*ordered_map(lambda _: threading.get_ident(), range(4))} == {threading.get_ident()}
    assert n_workers() == 2


def test_one_worker_is_the_caller_itself() -> None:
    set_workers(1)
    assert set(ordered_map(lambda _: threading.get_ident(), range(3))) == {threading.get_ident()}


def test_an_error_reaches_the_caller() -> None:
    set_workers(2)
    with pytest.raises(ZeroDivisionError):
        list(ordered_map(lambda k: 1 // k, [1, 0]))
