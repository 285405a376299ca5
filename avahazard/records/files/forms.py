"""The tables of a file by their forms, columns under their names and cells made plain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from avahazard.records.collection import Records
from avahazard.records.covariates import column_kinds
from avahazard.records.errors import RowProblem
from avahazard.records.files.cells import plain_cells
from avahazard.records.files.conventions import Conventions
from avahazard.records.files.spelling import refuse_near, spell
from avahazard.records.files.understood import summary, understood
from avahazard.records.forms.event import EventRow
from avahazard.records.forms.meanings import MEANINGS
from avahazard.records.forms.path import PathRow
from avahazard.records.forms.profile import ProfileRow
from avahazard.records.forms.row import Row
from avahazard.records.forms.straight import StraightRow
from avahazard.records.forms.velocity import VelocityRow
from avahazard.records.intake import Intake
from avahazard.records.plausible import check_ranges
from avahazard.records.recognise import Kind, recognise
from avahazard.records.table import Table

FORMS: dict[Kind, tuple[type[Row], ...]] = {
    "paths": (PathRow,),
    "profiles": (ProfileRow,),
    "events": (EventRow, StraightRow),
    "velocities": (VelocityRow,),
}
COLUMNS: dict[Kind, frozenset[str]] = {
    kind: frozenset(
        {
            *(column for form in forms for column in form.model_fields),
            *(column for column, meaning in MEANINGS.items() if kind in meaning.further),
        }
    )
    for kind, forms in FORMS.items()
}


def read_forms(
    sheets: Sequence[Table],
    known: Records,
    intake: Intake,
    faults: Sequence[RowProblem],
    need_runout: bool,
    given: Conventions,
) -> Iterator[tuple[Kind, Table]]:
    """Yield the tables of one file whose form is known; `faults` are those of reading it.

    What is wrong goes to `intake.problems`, where a wrong header stands for the faults of the
    rows under it. Of a workbook with a known form, sheets of no form are left out and told.
    """
    stored = {
        *column_kinds(path.covariates for path in known.paths),
        *column_kinds(event.covariates for event in known.events),
    }
    unknown: list[tuple[Table, list[RowProblem]]] = []
    found: list[tuple[Kind, Table]] = []
    wrong: list[RowProblem] = []
    for sheet in sheets:
        table = spell(sheet, stored, wrong)
        of_header: list[RowProblem] = []
        adds = need_runout and not _all_stored(table, known)
        kind = recognise(table, of_header, need_runout=adds)
        if kind is None and len(sheets) > 1 and not of_header[0].column:
            unknown.append((table, of_header))
            continue
        wrong += of_header
        if kind is None:
            continue
        refuse_near(table, COLUMNS[kind], wrong)
        table = plain_cells(table, given, intake.problems)
        check_ranges(table, intake.problems, intake.notes, unusual=given.unusual)
        intake.read.append(summary(table, kind))
        intake.understood += understood(table, kind, COLUMNS[kind])
        found.append((kind, table))
    for table, of_header in unknown:
        if found:
            intake.notes.append(f"{table.file}: not read, it has the columns of no form.")
        else:
            wrong += of_header
    intake.problems += wrong or faults
    yield from found


def _all_stored(table: Table, known: Records) -> bool:
    """Tell whether every event of the table is stored, so that its runout is."""
    stored = {event.event_id for event in known.events}
    if not stored or "event_id" not in table.header:
        return False
    return all(stored.issuperset(block) for block in table.blocks("event_id"))
