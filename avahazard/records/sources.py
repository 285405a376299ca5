"""Which files a call means: CSV files, or folders of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError


def find_files(sources: Sequence[str | FilePath]) -> list[FilePath]:
    """Return the CSV files that `sources` name, each once, in the order given.

    A folder stands for its `.csv` files (not those of its subfolders), by name.

    Raises:
        AvahazardError: a source does not exist, or a folder holds no CSV file.
    """
    found: dict[FilePath, FilePath] = {}
    for source in map(FilePath, sources):
        if source.is_dir():
            files = sorted(f for f in source.iterdir() if f.suffix.lower() == ".csv")
            if not files:
                raise AvahazardError(
                    f"The folder {source} holds no CSV file.",
                    "Name a folder with paths.csv, profiles.csv, events.csv or velocities.csv.",
                )
        elif source.exists():
            files = [source]
        else:
            raise AvahazardError(
                f"There is no file or folder {source}.", "Name CSV files, or folders of them."
            )
        for file in files:
            found.setdefault(file.resolve(), file)
    return list(found.values())
