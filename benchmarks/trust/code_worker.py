"""What runs the tests on changed code, in a process of its own: `python -m … cover|try`, JSON in
on standard input, one JSON document a line out.

A changed module never touches the disk: a forked child gets it in the place of the true one.
The numerical libraries are imported before the fork, the product and its tests after it.
Compiled code is what the true kernels gave (the cache cannot know of the change), so changes of
kernels are tried with NUMBA_DISABLE_JIT=1.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import traceback
import types
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import spec_from_file_location
from typing import Any

import pytest

from benchmarks.trust.code_changes import TRUE_CODE, changed
from benchmarks.trust.code_plugins import ROOT, Only, Watch

BEFORE_THE_FORK = (
    "matplotlib.pyplot", "numba", "pandas", "pydantic", "scipy.interpolate", "scipy.optimize",
    "scipy.stats", "sqlalchemy.orm",
)  # fmt: skip
MOST_MEMORY = 12 * 2**30
GRACE_S = 30
"""CPU that a child may take beyond thrice what its tests took before: imports, and a slow way."""
OPTIONS = ["-q", "--tb=no", "-p", "no:cacheprovider", "-m", "not slow"]
if os.environ.get("NUMBA_DISABLE_JIT") == "1":  # Python's numbers warn where compiled ones do not
    OPTIONS += ["-W", "ignore::RuntimeWarning"]


BROKEN = 99
ENDS = {0: "survived", 1: "killed", 2: "killed", 5: "no test"}
"""By pytest's status: 2 is a module that cannot be imported. What else happens is no test's work,
and does not count."""


class Instead:
    """Gives one module as this code; asked before all other finders."""

    def __init__(self, module: str, code: types.CodeType) -> None:
        self.name = module.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        self.module, self.code = module, code

    def find_spec(self, name: str, *_: object) -> ModuleSpec | None:
        if name != self.name:
            return None
        code = self.code

        class Loader(SourceFileLoader):
            def get_code(self, fullname: str) -> types.CodeType:  # noqa: ARG002
                return code

        file = str(ROOT / self.module)
        return spec_from_file_location(name, file, loader=Loader(name, file))


def cover(folders: list[str], tests: list[str], most_s: float) -> dict[str, Any]:
    """Run the tests on the true code."""
    watch = Watch(folders, most_s)
    watch.cover.start()
    with _quiet():
        pytest.main([*OPTIONS, *tests], plugins=[watch])
    watch.cover.stop()
    return {"seconds": watch.seconds, "failed": sorted(watch.failed), "lines": watch.covering()}


def attempt(module: str, number: int, tests: list[str], seconds: float) -> dict[str, Any]:
    """Run the tests on a changed module in a child; says how that ended, and what CPU it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = os.fork()
    if child == 0:
        code = BROKEN
        try:
            code = _child(module, number, tests, seconds)
        except Exception:
            traceback.print_exc()
        os._exit(code)
    _, status = os.waitpid(child, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if os.WIFSIGNALED(status):
        ended = "too long" if os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL) else "died"
    else:
        code = os.WEXITSTATUS(status)
        ended = ENDS.get(code, "broken")
    return {"module": module, "number": number, "ended": ended, "cpu": cpu}


def _child(module: str, number: int, tests: list[str], seconds: float) -> int:
    most = int(3 * seconds) + GRACE_S
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    if number != TRUE_CODE:
        source = (ROOT / module).read_text(encoding="utf-8")
        code = compile(changed(source, number), str(ROOT / module), "exec", dont_inherit=True)
        sys.meta_path.insert(0, Instead(module, code))
    files = sorted({name.partition("::")[0] for name in tests})
    with _quiet():
        return int(pytest.main([*OPTIONS, "-x", *files], plugins=[Only(tests)]))


@contextmanager
def _quiet() -> Iterator[None]:
    """Pytest's own words go nowhere, or into the file TRUST_WORDS: standard output is results."""
    sys.stdout.flush()
    kept = os.dup(1)
    words = os.environ.get("TRUST_WORDS", os.devnull)
    os.dup2(os.open(words, os.O_WRONLY | os.O_CREAT | os.O_APPEND), 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)


def main() -> None:
    os.environ["MPLBACKEND"] = "Agg"
    for name in BEFORE_THE_FORK:
        import_module(name)
    given = json.load(sys.stdin)
    if sys.argv[1] == "cover":
        print(json.dumps(cover(**given)), flush=True)
        return
    for one in given:
        print(json.dumps(attempt(**one)), flush=True)


if __name__ == "__main__":
    main()
