"""How this project compiles: one decorator, and a cache on disk that no edit makes stale.

numba's own cache of a function is fresh as long as that function's file is; the code of what it
calls in other files, and their constants, stand in it all the same. Here the cache is fresh as long
as no module with kernels has changed, nor any that such a module imports from.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

CONTRACT = {"contract"}
"""Fast-math flags of the kernels: products and sums may fuse; NaN and inf keep their meaning."""

PACKAGE = Path(__file__).parent
_IMPORT = re.compile(rb"^from avahazard\.([\w.]+) import", re.MULTILINE)


def kernel(
    function: Callable[..., Any] | None = None,
    *,
    inner: bool = False,
    borrows: bool = False,
    **flags: Any,
) -> Any:
    """Compile a function of arrays and floats, once for all processes: `@kernel`.

    It leaves Python's lock, a division by zero gives inf or nan, and `fastmath` is `CONTRACT`;
    `flags` are more of numba's (`@kernel(forceinline=True)`) or replace these. An `inner` one is
    called by other kernels alone: ways in from Python and from C take long to compile. One that
    `borrows` makes no array: else each look at an array of a tuple counts who holds it, twice by
    a locked instruction of some 20 cycles. It is never given a generator from Python, which it
    would hold for ever.
    """
    if function is None:
        return lambda later: kernel(later, inner=inner, borrows=borrows, **flags)
    settings = {"nogil": True, "error_model": "numpy", "fastmath": CONTRACT, **flags}
    settings |= {"no_cfunc_wrapper": True, "no_cpython_wrapper": inner}
    if borrows:
        settings["_nrt"] = False
    compiled = njit(**settings)(function)
    # What `cache=True` does, but for the class.
    compiled._cache = PackageCache(function)
    if inner:
        # Not a way in that leads nowhere.
        compiled._insert = lambda *_overload, **_more: None
        compiled._compile_for_args = _not_from_python
    return compiled


def _not_from_python(*_arguments: object, **_named: object) -> None:
    raise TypeError("This kernel is called by other kernels alone: it is `inner`.")


class PackageCache(FunctionCache):
    """numba's cache of a function, where numba puts it, with `package_stamp` in its version."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        # The version, not the stamp of the file: an index of another version is not even read. What
        # it names may be gone, and reading it would then fail.
        self._cache_file._version += f" {package_stamp()}"


@cache
def package_stamp() -> str:
    """Hash of the sources that compiled code is made of; read once for each process."""
    sources = {path: path.read_bytes() for path in PACKAGE.rglob("*.py")}
    used = {path for path, text in sources.items() if b"\n@kernel" in text}
    for path in tuple(used):
        for name in _IMPORT.findall(sources[path]):
            used.add(PACKAGE.joinpath(*name.decode().split(".")).with_suffix(".py"))
    whole = sha256()
    for path in sorted(used & sources.keys()):
        whole.update(str(path.relative_to(PACKAGE)).encode() + b"\0" + sources[path])
    return whole.hexdigest()
