"""Results as plain values that JSON can hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

AS_THEY_ARE = frozenset((str, int, bool, type(None)))


def plain(value: Any) -> Any:
    """Return `value` as dicts, lists, text, numbers and None.

    Arrays become lists, numpy scalars Python ones, and NaN or an infinity None. A dataclass gives
    its fields by `key_of`; those marked `absent` are left out where they are None.
    """
    if type(value) in AS_THEY_ARE:
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if is_dataclass(value):
        value = {
            key_of(field.name): item
            for field in fields(value)
            if (item := getattr(value, field.name)) is not None or not field.metadata.get("absent")
        }
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def key_of(field: str) -> str:
    """The key of a field: its name, less the underscore that tells it from a word of Python."""
    return field.removesuffix("_")
