"""The file of the user with the frequency of volumes."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated

from pydantic import Field

from avahazard.records.cells import plain_cells
from avahazard.records.conventions import UNKNOWN
from avahazard.records.errors import AvahazardError, RejectedRows, RowProblem, told_once
from avahazard.records.forms import spell
from avahazard.records.rows import ID, PLAIN, Name, Positive, Row, check_rows
from avahazard.records.sheet import read_tables


class ReturnVolumeRow(Row):
    """The volume of one return period on one path."""

    path_id: Name = Field(description=ID)
    return_period_years: Annotated[float, Field(gt=1, allow_inf_nan=False), PLAIN] = Field(
        description="a number of years over 1"
    )
    volume_m3: Positive = Field(description="a volume in m3, over 0")


def read_return_volumes(file: FilePath) -> dict[str, list[tuple[float, float]]]:
    """Rows of (return period in years, volume in m3) by path, in the order of the periods.

    Raises `AvahazardError` where the file cannot be read, and `RejectedRows` for rows that are
    not acceptable, such as a volume that is not over that of a shorter period.
    """
    problems: list[RowProblem] = []
    try:
        tables = read_tables(file, problems)
    except OSError as error:
        raise AvahazardError(
            f"The file {file} cannot be read: {error.strerror}.", "Name a CSV or .xlsx file."
        ) from error
    if len(tables) > 1:
        raise AvahazardError(
            f"The workbook {file} has {len(tables)} sheets with values.",
            "Leave one in it, or save that one as CSV.",
        )
    if not tables:
        raise RejectedRows(problems)
    table = plain_cells(spell(tables[0], (), problems), UNKNOWN, problems)
    by_path: dict[str, list[tuple[float, float, int]]] = {}
    for line, row in check_rows(ReturnVolumeRow, table.file, table.numbered(), problems):
        by_path.setdefault(row.path_id, []).append((row.return_period_years, row.volume_m3, line))
    for rows in by_path.values():
        rows.sort()
        for (years, before, _), (more_years, volume, line) in pairwise(rows):
            if more_years == years or volume <= before:
                accepted = f"a volume over {before:g}, that of {years:g} years; each period once"
                problems.append(RowProblem(str(file), line, "volume_m3", f"{volume:g}", accepted))
    if problems:
        raise RejectedRows(told_once(problems))
    if not by_path:
        columns = ", ".join(ReturnVolumeRow.model_fields)
        raise AvahazardError(f"The file {file} has no rows.", f"Its columns: {columns}.")
    return {key: [(years, volume) for years, volume, _ in rows] for key, rows in by_path.items()}
