"""A synthetic dataset or region on disk, in the forms that `import` reads."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.records.collection import Event, Path, Records, Speed
from avahazard.records.errors import AvahazardError
from avahazard.results.files import MadeWorld
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings


def write_world(
    folder: FilePath, records: Records, truth: Mapping[str, object]
) -> tuple[FilePath, ...]:
    """Write paths, profiles, events, velocities (when there are any) and `truth.json`.

    Returns the files. Raises AvahazardError when the folder has something in it.
    """
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
    """Write the records alone as CSV files, over what is there; returns the files."""
    files = []
    for name, (columns, rows) in record_tables(records).items():
        with (folder / name).open("w", newline="", encoding="utf-8") as handle:
            writer = csv.DictWriter(handle, columns, restval="", lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        files.append(folder / name)
    return tuple(files)


def record_tables(records: Records) -> dict[str, tuple[list[str], list[dict[str, object]]]]:
    """Columns and rows by the name of the file; those that would be empty are left out."""
    tables = {
        "paths.csv": _rows(records.paths),
        "profiles.csv": _profile_rows(records),
        "events.csv": _rows(records.events),
        "velocities.csv": _rows(records.speeds),
    }
    return {
        name: (list(dict.fromkeys(column for row in rows for column in row)), rows)
        for name, rows in tables.items()
        if rows
    }


def _rows(items: Sequence[Path | Event | Speed]) -> list[dict[str, object]]:
    """One row each: the fields that any of them has, then the covariates."""
    if not items:
        return []
    names = [f.name for f in fields(items[0]) if f.name != "covariates"]
    used = [n for n in names if any(getattr(item, n) is not None for item in items)]
    return [
        {n: _cell(getattr(item, n)) for n in used}
        | {n: _cell(v) for n, v in getattr(item, "covariates", {}).items()}
        for item in items
    ]


def _profile_rows(records: Records) -> list[dict[str, object]]:
    rows = []
    for p in records.profiles:
        columns: dict[str, Sequence[object]] = {"x_m": p.x_m.tolist(), "y_m": p.y_m.tolist()}
        if p.land_cover is not None:
            columns["land_cover"] = p.land_cover
        for name in ("easting_m", "northing_m", "lon", "lat", "elevation_sigma_m"):
            values = getattr(p, name)
            if values is not None:
                columns[name] = values.tolist()
        if p.crs is not None:
            columns["crs"] = [p.crs] * len(p.x_m)
        rows += [
            {"path_id": p.path_id} | dict(zip(columns, row, strict=True))
            for row in zip(*columns.values(), strict=True)
        ]
    return rows


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return int(value)
    return "" if value is None else value


PART_PATHS = 250
"""Paths of one part; no more are in memory at a time."""
FORMS = {
    name: [field.name for field in fields(form) if field.name != "covariates"]
    for name, form in (("paths.csv", Path), ("events.csv", Event), ("velocities.csv", Speed))
}
"""Columns by file."""


def write_region(
    folder: FilePath,
    seed: int,
    n_events: int,
    n_paths: int,
    effects: Mapping[str, float],
    settings: Settings,
) -> MadeWorld:
    """Write a region into a new or empty folder, part by part; `truth.json` has a truth a part.

    Winters and storms, and what else an effect draws for all paths, are drawn for each part anew.
    Raises as `make_world`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    counts = {"paths.csv": 0, "profiles.csv": 0, "events.csv": 0, "velocities.csv": 0}
    first: dict[str, Any] = {}
    n_left = 0
    target = folder / "truth.json"
    with ExitStack() as stack:
        truth_file = stack.enter_context(target.open("w", encoding="utf-8"))
        truth_file.write(f'{{"seed": {seed}, "n_events": {n_events}, "n_paths": {n_paths}, ')
        truth_file.write('"parts": [')
        writers: dict[str, csv.DictWriter[str]] = {}
        for k, (records, truth) in enumerate(_parts(seed, n_events, n_paths, effects, settings)):
            for name, (columns, rows) in record_tables(records).items():
                if name not in writers:
                    handle = (folder / name).open("w", newline="", encoding="utf-8")
                    stack.enter_context(handle)
                    # Another part may fill what is empty in the first.
                    whole = list(dict.fromkeys([*FORMS.get(name, ()), *columns]))
                    writers[name] = csv.DictWriter(handle, whole, restval="", lineterminator="\n")
                    writers[name].writeheader()
                writers[name].writerows(rows)
                counts[name] += len(rows)
            truth_file.write(("," if k else "") + "\n" + json.dumps(truth))
            first = first or dict(truth["effects"])
            n_left += sum(event.left_profile for event in records.events)
        truth_file.write("\n]}\n")
    return MadeWorld(
        folder=str(folder),
        files=tuple(str(file) for file in (*(folder / name for name in writers), target)),
        seed=seed,
        effects=first,
        n_paths=counts["paths.csv"],
        n_events=counts["events.csv"],
        n_left_profile=n_left,
        n_speeds=counts["velocities.csv"],
    )


def _parts(
    seed: int, n_events: int, n_paths: int, effects: Mapping[str, float], settings: Settings
) -> Iterator[tuple[Records, dict[str, Any]]]:
    """The parts with their own names of paths and events, and their truths."""
    ends = [*range(0, n_paths, PART_PATHS), n_paths]
    events = np.round(np.linspace(0, n_events, n_paths + 1)).astype(int)[ends]
    for k, (paths, some) in enumerate(zip(np.diff(ends), np.diff(events), strict=True), 1):
        (own,) = np.random.SeedSequence([seed, k]).generate_state(1)
        records, truth = make_world(int(own), int(some), int(paths), effects, settings)
        yield _named(records, f"R{k:03d}-"), {"part": f"R{k:03d}", **truth}


def _named(records: Records, prefix: str) -> Records:
    """The records with this before the names of paths and events."""

    def of_path(items: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(replace(item, path_id=prefix + item.path_id) for item in items)

    events = tuple(replace(e, event_id=prefix + e.event_id) for e in of_path(records.events))
    speeds = tuple(replace(s, event_id=prefix + s.event_id) for s in records.speeds)
    return Records(of_path(records.paths), of_path(records.profiles), events, speeds)
