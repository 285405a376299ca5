"""A function with what its calls share, pickled once and unpickled once in each worker."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cloudpickle

from avahazard.workers import one_worker

_kept: dict[str, tuple[Callable[[Any, Any], Any], Any]] = {}
"""The last that was unpickled in this worker."""


def pack(function: Callable[[Any, Any], Any], shared: object) -> tuple[str, bytes]:
    """A name for the two, by what they hold, and their bytes.

    cloudpickle takes functions inside functions too, which effects are made of.
    """
    data: bytes = cloudpickle.dumps((function, shared))
    return hashlib.sha256(data).hexdigest(), data


def call_packed(name: str, data: bytes | Path, item: object) -> Any:
    """Call the function on an item in a worker; `data` are the bytes, or the file with them."""
    found = _kept.get(name)
    if found is None:
        content = data if isinstance(data, bytes) else data.read_bytes()
        found = cloudpickle.loads(content)
        _kept.clear()
        _kept[name] = found
    function, shared = found
    with one_worker():
        return function(shared, item)
