"""Compiled kernels survive the process that compiled them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest
from numba import config

from avahazard import kernels
from avahazard.kernels import bare, kernel

PROGRAM = """
import numpy as np
from avahazard.physics import block, speed
from avahazard.physics.cells import build_cells
from avahazard.physics.cells import no_resistance
from avahazard.physics.smooth_profile import legendre_profile
from avahazard.physics.terrain import build_terrain

x = np.linspace(0.0, 900.0, 50)
terrain = build_terrain(legendre_profile(x, 500.0 * np.exp(-x / 400.0)))
cells = build_cells(terrain, no_resistance(terrain))
block.run(cells, np.array([0]), np.array([0.5]))
speed.speeds_along(cells, 0, np.array([0.5]), np.array([100.0]))
for kernel in (block.run_near, speed._speeds):
    print(sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""


def counts(cache: Path) -> list[str]:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


@pytest.mark.slow
def test_a_second_process_does_not_compile(tmp_path: Path) -> None:
    assert counts(tmp_path) == ["0 1", "0 1"]
    assert counts(tmp_path) == ["1 0", "1 0"]


PACKAGE = {
    "constants.py": "STEP = 1.0\n",
    "callee.py": """
from avahazard.constants import STEP
from avahazard.kernels import kernel

@kernel(inner=True)
def inner(x):
    return x + STEP
""",
    "caller.py": """
from avahazard.callee import inner
from avahazard.kernels import kernel

@kernel
def outer(x):
    return 2.0 * inner(x)
""",
    "apart.py": "UNUSED = 1\n",
}


def copied(folder: Path) -> Path:
    """A package with the decorator of this one and two kernels, one of which calls the other."""
    package = folder / "avahazard"
    package.mkdir()
    shutil.copy(kernels.__file__, package / "kernels.py")
    for name, text in {**PACKAGE, "__init__.py": ""}.items():
        (package / name).write_text(text)
    return package


def call(folder: Path, **environment: str) -> tuple[float, int]:
    """What `outer(1.0)` gives in a new process, and how often it was found compiled.

    A fork, that loads the package anew, has numba already: starting it takes a second.
    """
    context = get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_call, args=(folder, environment, sender))
    process.start()
    sender.close()
    try:
        return receiver.recv()
    finally:
        process.join()


def _call(folder: Path, environment: dict[str, str], sender: Connection) -> None:
    os.environ.update(environment)
    config.CACHE_DIR = environment.get("NUMBA_CACHE_DIR", "")
    # Bytecode is taken for fresh by whole seconds and its length; edits here come faster.
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    for name in [name for name in sys.modules if name.split(".")[0] == "avahazard"]:
        del sys.modules[name]
    outer = import_module("avahazard.caller").outer
    sender.send((outer(1.0), sum(outer.stats.cache_hits.values())))


def test_an_edit_in_another_file_reaches_the_caller(tmp_path: Path) -> None:
    package = copied(tmp_path)
    assert call(tmp_path) == (4.0, 0)
    (package / "apart.py").write_text("UNUSED = 2\n")
    assert call(tmp_path) == (4.0, 1)
    (package / "callee.py").write_text(PACKAGE["callee.py"].replace("x + STEP", "x - STEP"))
    assert call(tmp_path) == (0.0, 0)
    (package / "constants.py").write_text("STEP = -1.0\n")
    assert call(tmp_path) == (4.0, 0)


def test_an_edit_compiles_its_module_and_those_that_build_on_it(tmp_path: Path) -> None:
    package = copied(tmp_path)
    assert call(tmp_path) == (4.0, 0)
    (package / "beside.py").write_text(PACKAGE["caller.py"].replace("2.0 *", "3.0 *"))
    assert call(tmp_path) == (4.0, 1)


def test_python_runs_an_inner_kernel_as_it_stands() -> None:
    @kernels.kernel(inner=True)
    def inner(x: float) -> float:
        return x + 1.0

    @kernels.kernel
    def outer(x: float) -> float:
        return 2.0 * inner(x)

    assert outer(1.0) == 4.0
    assert inner(1.0) == 2.0


def test_few_folders_of_former_sources_are_kept(tmp_path: Path) -> None:
    package = copied(tmp_path)
    for step in range(kernels.KEPT + 2):
        (package / "constants.py").write_text(f"STEP = {step}.0\n")
        assert call(tmp_path) == (2.0 + 2.0 * step, 0)
    assert len(list((package / "__pycache__").glob("avahazard.caller-*"))) == kernels.KEPT
    assert call(tmp_path) == (2.0 + 2.0 * step, 1)


def test_what_is_compiled_is_kept_where_the_package_cannot_be_written(tmp_path: Path) -> None:
    package = copied(tmp_path)
    (package / "__pycache__").write_text("no folder")
    home = {"XDG_CACHE_HOME": str(tmp_path / "home"), "HOME": str(tmp_path / "home")}
    assert call(tmp_path, **home) == (4.0, 0)
    assert call(tmp_path, **home) == (4.0, 1)


def test_nothing_is_kept_where_nothing_can_be_written(tmp_path: Path) -> None:
    package = copied(tmp_path)
    (package / "__pycache__").write_text("no folder")
    (tmp_path / "home").write_text("no folder")
    home = {"XDG_CACHE_HOME": str(tmp_path / "home"), "HOME": str(tmp_path / "home")}
    assert call(tmp_path, **home) == (4.0, 0)
    assert call(tmp_path, **home) == (4.0, 0)


def test_the_folder_that_numba_is_given_comes_first_and_is_given_back(tmp_path: Path) -> None:
    package = copied(tmp_path)
    given = tmp_path / "given"
    assert call(tmp_path, NUMBA_CACHE_DIR=str(given)) == (4.0, 0)
    assert call(tmp_path, NUMBA_CACHE_DIR=str(given)) == (4.0, 1)
    assert not (package / "__pycache__").exists()


def test_what_kernels_take_from_other_modules_is_in_the_name_of_their_folder() -> None:
    """Kernels, constants and named tuples are in it; of others only what numpy and Python give."""
    for path in kernels.PACKAGE.rglob("*.py"):
        if "\n@kernel" in path.read_text():
            import_module(".".join(path.relative_to(kernels.PACKAGE.parent).with_suffix("").parts))
    for compiled in kernels.STAMPS:
        function = getattr(compiled, "py_func", compiled)
        for name in function.__code__.co_names:
            used = function.__globals__.get(name)
            ours = (getattr(used, "__module__", None) or "").startswith("avahazard")
            stated = isinstance(used, kernels.CONSTANTS) or hasattr(used, "_fields")
            stated |= used is bare  # of kernels.py, which is in all of them
            assert not ours or used in kernels.STAMPS or stated, (function, name)
            assert not isinstance(used, ModuleType) or used.__name__ in {"math", "numpy"}, function


def test_every_kernel_of_the_package_has_the_one_spelling() -> None:
    for path in kernels.PACKAGE.rglob("*.py"):
        assert path == kernels.PACKAGE / "kernels.py" or "njit" not in path.read_text(), path


def test_an_index_whose_classes_are_gone_is_passed_over(tmp_path: Path) -> None:
    """What kernels are called with may be renamed: what they were called with cannot be read."""
    package = copied(tmp_path)
    caller = package / "caller.py"
    pair = """
from typing import NamedTuple
from avahazard.callee import inner
from avahazard.kernels import kernel

class Pair(NamedTuple):
    x: float

@kernel
def of_pair(pair):
    return 2.0 * inner(pair.x)

def outer(x):
    return of_pair(Pair(x))

outer.stats = of_pair.stats
"""
    caller.write_text(pair)
    assert call(tmp_path) == (4.0, 0)
    caller.write_text(pair.replace("Pair", "Couple"))
    assert call(tmp_path) == (4.0, 0)
    assert call(tmp_path) == (4.0, 1)


class Both(NamedTuple):
    """Two arrays and a number."""

    first: np.ndarray
    others: tuple[np.ndarray, float]


@kernel
def summed(both, rows):  # type: ignore[no-untyped-def]
    both, rows = bare(both), bare(rows)
    total = np.zeros(len(rows))
    for i in range(len(rows)):
        row, other = rows[i], both.others[0][i:]
        total[i] = np.sum(row * both.first) + both.others[1] * other[0]
    return total


@kernel
def of_own(n):  # type: ignore[no-untyped-def]
    first = np.arange(n) + 0.5
    return summed(Both(first, (2.0 * first, 3.0)), np.ones((n, n)))


def test_bare_arguments_are_the_same_and_stay_with_who_gave_them() -> None:
    first = np.arange(4) + 0.5
    both, rows = Both(first, (2.0 * first, 3.0)), np.ones((4, 4))
    held = [sys.getrefcount(a) for a in (first, both.others[0], rows)]
    expected = first.sum() + 6.0 * first
    for _ in range(100):
        np.testing.assert_array_equal(summed(both, rows), expected)
        np.testing.assert_array_equal(of_own(4), expected)
    assert [sys.getrefcount(a) for a in (first, both.others[0], rows)] == held
