"""Import of records: all of a call, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path as FilePath
from typing import Any

from avahazard.records.errors import RejectedRows
from avahazard.records.merge import merge_records
from avahazard.records.reading import read_files
from avahazard.store.records import load_records, save_records
from avahazard.store.session import reading, writing


def import_files(
    database: str,
    sources: Sequence[str | FilePath],
    *,
    update: bool = False,
    dry_run: bool = False,
) -> dict[str, Any]:
    """Import `sources`, CSV files or folders of them (contract, section 1), into `database`.

    Rows that are stored already are no change; with `update` rows that contradict stored
    ones replace them. A dry run reports what would happen. Returns the files, the counts
    `{"new", "unchanged", "updated"}` of paths, profiles, events and speeds, and notes.

    Raises:
        AvahazardError: the database or a source cannot be used.
        RejectedRows: rows that cannot be taken, all of them; nothing was stored.
    """
    with (reading if dry_run else writing)(database) as session:
        stored = load_records(session)
        intake = read_files(sources, stored)
        merge = merge_records(intake, stored, update=update)
        if intake.problems:
            raise RejectedRows(intake.problems)
        if not dry_run:
            save_records(session, merge.write)
    return {
        "dry_run": dry_run,
        "files": intake.files,
        "records": {kind: asdict(count) for kind, count in merge.counts.items()},
        "notes": intake.notes,
    }
