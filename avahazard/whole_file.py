"""A file that is there whole or not at all, also after a power cut."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def written_whole(file: Path) -> Iterator[Path]:
    """Give a name beside `file` to write to; what is there at the end is synced and called `file`.

    That name may be taken. Raises `OSError` where the disk refuses it; after any error `file` is as
    it was, with nothing beside it.
    """
    # Under a name that none takes for the file; of a process that was killed there may be one.
    part = file.with_name(f".{file.stem}.{os.getpid()}.part{file.suffix}")
    part.unlink(missing_ok=True)
    try:
        yield part
        _sync(part, os.O_RDWR)
        part.replace(file)
        if sys.platform != "win32":  # a folder cannot be opened there, and its names are kept
            _sync(file.absolute().parent, os.O_RDONLY)
    except OSError as error:
        if str(error.filename) == str(part):
            error.filename = str(file)  # the name that was asked for
        raise
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _sync(path: Path, flags: int) -> None:
    opened = os.open(path, flags)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
