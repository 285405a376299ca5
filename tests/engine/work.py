"""Work for the engines' tests; workers import it."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.seeds import generator
from avahazard.workers import n_workers


def draws(seed: int, item: int) -> NDArray[np.float64]:
    """Numbers that hang on the seed and the item alone."""
    return generator(seed, "work", item).standard_normal(5)


def draws_or_death(shared: tuple[int, Path], item: int) -> NDArray[np.float64]:
    """The same; the first worker that comes to item 5 is killed there."""
    seed, folder = shared
    if item == 5:
        try:
            (folder / "killed").touch(exist_ok=False)
        except FileExistsError:
            pass
        else:
            os.kill(os.getpid(), signal.SIGKILL)
    return draws(seed, item)


def always_death(_shared: None, _item: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def inside(_shared: None, _item: int) -> tuple[int, int]:
    """The process, and how many workers the work of a worker sees."""
    return os.getpid(), n_workers()


def discontinuous(_shared: None, item: int) -> float:
    return 1.0 / (item - 3)


def counted(n: int, taken: list[int]) -> Iterator[int]:
    """Items 0 to n - 1, each noted as it is taken."""
    for item in range(n):
        taken.append(item)
        yield item
