"""What the workers of one test run share: what takes long is made, and compiled, by one of them."""

from __future__ import annotations

import compileall
import fcntl
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from _pytest.assertion import rewrite

WORKER = "PYTEST_XDIST_WORKER" in os.environ
TOP = Path(__file__).resolve().parents[1]


@contextmanager
def locked(file: Path, flags: int = os.O_RDWR | os.O_CREAT) -> Iterator[None]:
    """Hold a file that one process at a time can hold; the others wait."""
    handle = os.open(file, flags)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a folder that `make` has filled, once for all workers; do not write to it."""
    top = factory.getbasetemp().parent if WORKER else factory.getbasetemp()
    folder, done = top / f"once-{name}", top / f"once-{name}.made"
    with locked(top / f"once-{name}.lock"):
        if not done.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            make(folder)
            done.touch()
    return folder


def my_share(files: list[Path]) -> list[Path]:
    """Every n-th of `files`, where n workers run."""
    me = int(os.environ["PYTEST_XDIST_WORKER"].removeprefix("gw"))
    return files[me :: int(os.environ["PYTEST_XDIST_WORKER_COUNT"])]


def bytecode_once(config: pytest.Config) -> None:
    """Make this worker's share of the bytecode that a clean tree lacks.

    All workers import the same modules in the same order, so each would make all of it.
    """
    if sys.dont_write_bytecode:
        return
    for file in my_share(sorted(TOP.glob("avahazard/**/*.py"))):
        compileall.compile_file(file, quiet=1)
    state = config.stash[rewrite.assertstate_key]
    for file in my_share(sorted(TOP.glob("tests/**/test_*.py"))):
        folder = rewrite.get_cache_dir(file)
        pyc = folder / (file.stem + rewrite.PYC_TAIL)
        if rewrite._read_pyc(file, pyc) is None and rewrite.try_makedirs(folder):
            source, code = rewrite._rewrite_test(file, config)
            rewrite._write_pyc(state, code, source, pyc)


def compile_once() -> None:
    """Let a worker wait for what another one compiles, and load that.

    What modules of tests call while they are imported all workers compile, or wait for, at once.
    """
    from numba.core.compiler_lock import global_compiler_lock  # noqa: PLC0415
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

    compile_it = Dispatcher.compile
    held: set[str] = set()

    def compile_alone(self: Any, signature: Any) -> Any:
        # numba's own lock first, so that the threads of a process never wait for each other's file.
        with global_compiler_lock:
            source = self.py_func.__code__.co_filename
            if source in held or not os.path.exists(source):
                return compile_it(self, signature)
            held.add(source)
            try:
                with locked(Path(source), os.O_RDONLY):
                    return compile_it(self, signature)
            finally:
                held.discard(source)

    Dispatcher.compile = compile_alone
