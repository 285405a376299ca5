"""Which files a call means: tables, or folders of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath

from avahazard.records.errors import AvahazardError

TABLES = (".csv", ".tsv", ".xlsx", ".xlsm")
OTHERS = (".xls", ".xlsb", ".ods", ".numbers")


def find_files(sources: Sequence[str | FilePath]) -> list[FilePath]:
    """Return the files of tables that `sources` name, each once, in the order given.

    A folder stands for its `.csv`, `.tsv` and `.xlsx` files (not those of its subfolders), by name.

    Raises:
        AvahazardError: a source does not exist, a folder holds no such file, holds two of one
            name, or a spreadsheet of another kind.
    """
    found: dict[FilePath, FilePath] = {}
    for source in map(FilePath, sources):
        if source.is_dir():
            files = _in_folder(source)
        elif source.exists():
            files = [source]
        else:
            raise AvahazardError(
                f"There is no file or folder {source}.",
                "Name files (.csv, .xlsx), or folders of them.",
            )
        for file in files:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _in_folder(folder: FilePath) -> list[FilePath]:
    # Names that begin so are locks of an open spreadsheet, or hidden.
    listed = sorted(f for f in folder.iterdir() if not f.name.startswith(("~$", ".")))
    files = [f for f in listed if f.suffix.lower() in TABLES]
    stems: dict[str, FilePath] = {}
    for file in files:
        other = stems.setdefault(file.stem.lower(), file)
        if other is not file:
            raise AvahazardError(
                f"{folder} holds {other.name} and {file.name}: which one counts?",
                f"Name the file, such as: avahazard import {other}; or take the other away.",
            )
    for file in listed:
        if file.suffix.lower() in OTHERS:
            raise AvahazardError(
                f"{file} is a spreadsheet of a kind that is not read.",
                "Save it as .xlsx or CSV, or take it out of the folder.",
            )
    if not files:
        raise AvahazardError(
            f"The folder {folder} holds no table (.csv, .xlsx).",
            "Name a folder with paths, profiles, events or velocities as .csv or .xlsx.",
        )
    return files
