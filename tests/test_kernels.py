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

import numpy as np
import pytest
from numba.core.errors import TypingError

from avahazard import kernels

PROGRAM = """
import numpy as np
from avahazard.physics import block, speed
from avahazard.physics.cells import build_cells
from avahazard.physics.resistance import no_resistance
from avahazard.physics.smooth_profile import legendre_profile
from avahazard.physics.terrain import build_terrain

x = np.linspace(0.0, 900.0, 50)
terrain = build_terrain(legendre_profile(x, 500.0 * np.exp(-x / 400.0)))
cells = build_cells(terrain, no_resistance(terrain))
block.run(cells, np.array([0]), np.array([0.5]))
speed.speeds_along(cells, 0, np.array([0.5]), np.array([100.0]))
for kernel in (block._run, speed._speeds):
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


def test_an_inner_kernel_is_not_called_from_python() -> None:
    @kernels.kernel(inner=True)
    def inner(x: float) -> float:
        return x + 1.0

    @kernels.kernel
    def outer(x: float) -> float:
        return 2.0 * inner(x)

    assert outer(1.0) == 4.0
    for _ in range(2):
        with pytest.raises(TypeError, match="other kernels alone"):
            inner(1.0)


def test_a_kernel_that_borrows_reads_arrays_and_makes_none() -> None:
    @kernels.kernel(borrows=True)
    def total(values: np.ndarray) -> float:
        return values[0] + values[1]

    @kernels.kernel(borrows=True)
    def made(n: int) -> float:
        return np.zeros(n)[0]

    assert total(np.array([1.0, 2.0])) == 3.0
    with pytest.raises(TypingError):
        made(2)


def test_what_is_compiled_is_kept_where_the_package_cannot_be_written(tmp_path: Path) -> None:
    package = copied(tmp_path)
    (package / "__pycache__").write_text("no folder")
    home = {"XDG_CACHE_HOME": str(tmp_path / "home"), "HOME": str(tmp_path / "home")}
    assert call(tmp_path, **home) == (4.0, 0)
    assert call(tmp_path, **home) == (4.0, 1)


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
