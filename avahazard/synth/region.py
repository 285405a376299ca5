"""A region too large for one world: worlds of some paths each, made and written one by one."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, fields, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path
from avahazard.synth.making import make_world
from avahazard.synth.settings import Settings
from avahazard.synth.writing import record_tables

PART_PATHS = 250
"""Paths of one part; no more are in memory at a time."""
FORMS = {
    name: [field.name for field in fields(form) if field.name != "covariates"]
    for name, form in (("paths.csv", Path), ("events.csv", Event), ("velocities.csv", Speed))
}
"""Columns by file."""


@dataclass(frozen=True, slots=True)
class Written:
    """What was written; `effects` are those of the first part."""

    files: tuple[FilePath, ...]
    effects: dict[str, Any]
    n_paths: int
    n_events: int
    n_left_profile: int
    n_speeds: int


def write_region(
    folder: FilePath,
    seed: int,
    n_events: int,
    n_paths: int,
    effects: Mapping[str, float],
    settings: Settings,
) -> Written:
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
    return Written(
        files=(*(folder / name for name in writers), target),
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
