"""Checksums of what is stored: a page that was swapped, zeroed or edited is then found."""

from __future__ import annotations

import hashlib
import json
from typing import Any


def document_checksum(model: str, document: Any) -> str:
    """SHA-256 of a result by `model`, the same before it is stored and after it is read."""
    # Keys become texts in the database.
    text = _sorted(json.loads(json.dumps(document)))
    return hashlib.sha256(f"{model}\n{text}".encode()).hexdigest()


def path_checksum(
    run: int, position: int, path_id: str, result: Any, notes: Any, failed: str | None
) -> str:
    """SHA-256 of what was found on one path of a run of `hazard` or `zones`; all keys are texts."""
    text = _sorted([run, position, path_id, result, notes, failed])
    return hashlib.sha256(text.encode()).hexdigest()


def _sorted(document: Any) -> str:
    # The order of keys in the database is nobody's business.
    return json.dumps(document, sort_keys=True, ensure_ascii=False)


def chunk_checksum(
    calibration: int, parameter: str, chunk: int, shape: tuple[int, int], data: bytes
) -> str:
    """SHA-256 of a chunk of draws of `shape` (chains, draws) and of the place where it belongs."""
    place = f"{calibration}\n{parameter}\n{chunk}\n{shape[0]} {shape[1]}\n".encode()
    return hashlib.sha256(place + data).hexdigest()
