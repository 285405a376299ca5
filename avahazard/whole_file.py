"""A file that is there whole or not at all, also after a power cut."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def put_in_place(part: Path, file: Path) -> None:
    """Sync `part` to the disk and give it the name `file`, which may be taken.

    Raises `OSError` where the disk refuses it; `file` is then as it was.
    """
    _sync(part, os.O_RDWR)
    part.replace(file)
    if sys.platform != "win32":  # a folder cannot be opened there, and its names are kept anyway
        _sync(file.absolute().parent, os.O_RDONLY)


def _sync(path: Path, flags: int) -> None:
    opened = os.open(path, flags)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
