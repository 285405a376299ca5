"""How this project compiles: one decorator, and a cache on disk that no edit makes stale.

numba's cache of a function (`cache=True`) is fresh as long as that function's file is, although the
code of what it calls in other files, and their constants, stand in it. Here the functions of a
module are cached in a folder whose name holds a hash of all that their code is made of: an edit
compiles that module anew and those whose kernels use what it defines.
"""

import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryFile
from threading import Lock
from typing import Any, TypeVar

import numpy as np
from numba import config as numba_config
from numba import njit, types
from numba.extending import intrinsic, overload, register_jitable
from numba.misc.appdirs import AppDirs

CONTRACT = {"contract"}
"""Fast-math flags of the kernels: products and sums may fuse; NaN and inf keep their meaning."""

PACKAGE = Path(__file__).parent
CONSTANTS = (bool, int, float, complex, str, bytes, tuple, np.generic, np.ndarray)
config: Any = numba_config  # its settings are no part of its types
KEPT = 4
"""Folders that a module keeps: of the present sources and of those before."""

T = TypeVar("T")
_TUPLE = re.compile(rb"^class \w+\(NamedTuple\):\n(?:(?:    .*)?\n)+", re.MULTILINE)
_lock = Lock()
STAMPS: dict[Any, str] = {}
"""Of each kernel, what the cache of its module is named by."""

_of_module: dict[str, str] = {}


def kernel(function: Callable[..., Any] | None = None, *, inner: bool = False, **flags: Any) -> Any:
    """Compile a function of arrays and floats, once for all processes: `@kernel`.

    It leaves Python's lock, a division by zero gives inf or nan, and `fastmath` is `CONTRACT`;
    `flags` are more of numba's (`@kernel(forceinline=True)`) or replace these. An `inner` one is
    compiled as a part of the kernels that call it, which is quicker; Python runs it as it stands.
    """
    if function is None:
        return lambda later: kernel(later, inner=inner, **flags)
    settings = {"nogil": True, "error_model": "numpy", "fastmath": CONTRACT, **flags}
    with _folder_of(function) as folder:
        if inner:
            compiled = register_jitable(**settings)(function)
        else:
            settings |= {"cache": folder is not None, "no_cfunc_wrapper": True}
            compiled = njit(**settings)(function)
        STAMPS[compiled] = _stamp(function)
    return compiled


def bare(arrays: T) -> T:
    """Arguments of a kernel, an array or a tuple of some, without counts of their references.

    Whoever calls a kernel holds what it gives. numba counts references to each view all the same,
    by an atomic instruction, which in short loops took up to two thirds of the time. No view of
    what is bare may be returned, and only arguments may be made so: numba frees the others.
    """
    return arrays


@overload(bare)
def _bare(arrays):  # type: ignore[no-untyped-def] # noqa: ARG001 (its type)
    def without(arrays):  # type: ignore[no-untyped-def]
        return _without_owner(arrays)  # type: ignore[call-arg]

    return without


@intrinsic
def _without_owner(_context: Any, arrays: Any) -> Any:
    def made(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
        return _stripped(context, builder, arrays, given[0])

    return arrays(arrays), made


def _stripped(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value of a numba type with no owner of its memory."""
    if isinstance(kind, types.Array):
        for field in ("meminfo", "parent"):
            k = context.data_model_manager[kind].get_field_position(field)
            value = builder.insert_value(value, value.type.elements[k](None), k)
    elif hasattr(kind, "count"):  # a tuple
        for k in range(kind.count):
            part = _stripped(context, builder, kind[k], builder.extract_value(value, k))
            value = builder.insert_value(value, part, k)
    return value


@contextmanager
def _folder_of(function: Callable[..., Any]) -> Iterator[Path | None]:
    """Let numba cache what is decorated in the folder of the function's module, if there is one."""
    with _lock:
        before = config.CACHE_DIR
        base = _base(before)
        try:
            if base is not None:
                folder = base / f"{function.__module__}-{_stamp(function)}"
                if not folder.is_dir():
                    _make_room(folder)
                config.CACHE_DIR = str(folder)
            yield base
        finally:
            config.CACHE_DIR = before


@cache
def _base(given: str) -> Path | None:
    """The first folder that can be written, in numba's order: given, the package's, the user's."""
    user = AppDirs(appname="numba", appauthor=False).user_cache_dir  # type: ignore[no-untyped-call]
    for base in (Path(given) if given else None, PACKAGE / "__pycache__", Path(user)):
        if base is None:
            continue
        try:
            base.mkdir(parents=True, exist_ok=True)
            TemporaryFile(dir=base).close()
        except OSError:
            continue
        return base
    return None


def _make_room(folder: Path) -> None:
    """Remove the oldest folders of other sources of a module, of which a new one is to be made."""
    name = folder.name.rsplit("-", 1)[0]
    others = sorted(folder.parent.glob(f"{name}-*"), key=lambda other: other.stat().st_mtime)
    for other in others[: -(KEPT - 1)]:
        shutil.rmtree(other, ignore_errors=True)


def _stamp(function: Callable[..., Any]) -> str:
    """Hash of a module's source and of the kernels and constants that it imports.

    Known as the module's first kernel is decorated: what it imports stands above.
    """
    module, names = function.__module__, function.__globals__
    if module not in _of_module:
        whole = sha256(_package() + Path(function.__code__.co_filename).read_bytes())
        for name in sorted(names):
            if not name.startswith("__"):
                whole.update(f"{name} {_state(names[name])}\n".encode())
        _of_module[module] = whole.hexdigest()[:16]
    return _of_module[module]


def _state(value: Any) -> str:
    """What a compiled function takes from a global value; empty for what it cannot use."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tolist()}"
    if isinstance(value, tuple):
        return " ".join(map(_state, value))
    if isinstance(value, CONSTANTS):
        return repr(value)
    return STAMPS.get(value, "") if callable(value) else ""


@cache
def _package() -> bytes:
    """What every kernel rests on: this file, and the tuples that kernels may be called with."""
    texts = ((path.name, _TUPLE.findall(path.read_bytes())) for path in PACKAGE.rglob("*.py"))
    return Path(__file__).read_bytes() + repr(sorted(text for text in texts if text[1])).encode()
