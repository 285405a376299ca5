"""Results as plain values that JSON can hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from avahazard.notes import Note

AS_THEY_ARE = frozenset((str, int, bool, type(None)))


def plain(value: Any, *, keyed: bool = False) -> Any:
    """Return `value` as dicts, lists, text, numbers and None.

    Arrays become lists, numpy scalars Python ones, and NaN or an infinity None. A dataclass gives
    its fields by `key_of`; those marked `absent` are left out where they are None. A note is its
    sentence or, `keyed`, its key and values, as the database holds it.
    """
    if type(value) in AS_THEY_ARE:
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Note):
        value = value.stored() if keyed else str(value)
    elif is_dataclass(value):
        value = {
            key_of(field.name): item
            for field in fields(value)
            if (item := getattr(value, field.name)) is not None or not field.metadata.get("absent")
        }
    if hasattr(value, "tolist"):
        return plain(value.tolist(), keyed=keyed)
    if isinstance(value, Mapping):
        return {str(key): plain(item, keyed=keyed) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, keyed=keyed) for item in value]
    return value


def key_of(field: str) -> str:
    """The key of a field: its name, less the underscore that tells it from a word of Python."""
    return field.removesuffix("_")
