"""A synthetic dataset on disk, in the forms that `import` reads."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path as FilePath

import numpy as np

from avahazard.records.collection import Event, Path, Records, Speed
from avahazard.records.errors import AvahazardError


def write_dataset(
    folder: FilePath, records: Records, truth: Mapping[str, object]
) -> tuple[FilePath, ...]:
    """Write the records and `truth.json` to an empty folder, else refuse; return the files."""
    refuse_full(folder)
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / "truth.json"
    try:
        files = write_records(folder, records)
        target.write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    except BaseException:
        # Half a dataset would block the next try; the folder was empty before.
        for file in folder.iterdir():
            file.unlink()
        raise
    return (*files, target)


def refuse_full(folder: FilePath) -> None:
    """Raise AvahazardError when the folder has something in it, or is no folder."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise AvahazardError(
            f"{folder} is not an empty folder.", "Name a new folder, or empty this one."
        )


def write_records(folder: FilePath, records: Records) -> tuple[FilePath, ...]:
    """Write the records alone as CSV files, over what is there; returns the files, none empty."""
    tables = {
        "paths.csv": _rows(records.paths),
        "profiles.csv": _profile_rows(records),
        "events.csv": _rows(records.events),
        "velocities.csv": _rows(records.speeds),
    }
    files = []
    for name, rows in tables.items():
        if rows:
            columns = list(dict.fromkeys(column for row in rows for column in row))
            with (folder / name).open("w", newline="", encoding="utf-8") as handle:
                writer = csv.DictWriter(handle, columns, restval="", lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
            files.append(folder / name)
    return tuple(files)


def _rows(items: Sequence[Path | Event | Speed]) -> list[dict[str, object]]:
    """One row each: the fields that any of them has, then the covariates."""
    names = [f.name for item in items[:1] for f in fields(item) if f.name != "covariates"]
    used = [n for n in names if any(getattr(item, n) is not None for item in items)]
    return [
        {n: _cell(getattr(item, n)) for n in used}
        | {n: _cell(v) for n, v in getattr(item, "covariates", {}).items()}
        for item in items
    ]


def _profile_rows(records: Records) -> list[dict[str, object]]:
    rows = []
    for p in records.profiles:
        columns = {
            f.name: np.broadcast_to(values, len(p.x_m)).tolist()
            for f in fields(p)
            if (values := getattr(p, f.name)) is not None
        }
        rows += [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ]
    return rows


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return int(value)
    return "" if value is None else value
