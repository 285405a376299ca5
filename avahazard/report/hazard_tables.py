"""Design runouts, runouts of volumes and zones as tables in a file: CSV or workbook."""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any

from avahazard.notes import ENGLISH
from avahazard.results.hazard import Design, HazardRow, RunoutInterval, ZonedPath

QUANTILES = ("q05", "q50", "q95")
STATISTICS = ("mean", *QUANTILES)
APART = ("natural", "parameters")
FIRST_COLUMNS = "path_id,return_period_years,volume_m3,"
FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def write_hazard(file: FilePath, rows: Sequence[HazardRow]) -> None:
    """Write the rows of `hazard` as CSV: lengths in m, an empty cell beyond the profile.

    Texts that a spreadsheet would run as formulas begin with an apostrophe.
    """
    columns, flat = hazard_sheet(rows)
    with file.open("w", newline="", encoding="utf-8") as handle:
        # Lines end as RFC 4180 has it, which also puts quotes around what holds such an end.
        writer = csv.DictWriter(handle, columns)
        writer.writeheader()
        writer.writerows(
            {
                name: f"'{v}" if isinstance(v, str) and v.startswith(FORMULA_STARTS) else v
                for name, v in row.items()
            }
            for row in flat
        )


Sheet = tuple[list[str], list[dict[str, Any]]]
"""The columns of a table, and the cells of each row by column."""


def hazard_sheet(rows: Sequence[HazardRow]) -> Sheet:
    """The rows of `hazard`."""
    return _sheet(map(hazard_cells, rows))


def zones_sheet(entries: Sequence[ZonedPath]) -> Sheet:
    """The zones of the paths."""
    return _sheet(
        {"path_id": entry.path_id, "limits": entry.limits, **zone.to_dict()}
        for entry in entries
        for zone in entry.zones
    )


def _sheet(rows: Iterable[dict[str, Any]]) -> Sheet:
    flat = [{k: round(v, 4) if isinstance(v, float) else v for k, v in r.items()} for r in rows]
    return list(dict.fromkeys(name for row in flat for name in row)), flat


def is_own_csv(file: FilePath) -> bool:
    """Whether `file` was made by `write_hazard`."""
    with file.open("rb") as handle:
        return handle.read(len(FIRST_COLUMNS)) == FIRST_COLUMNS.encode()


def hazard_cells(row: HazardRow) -> dict[str, Any]:
    """The cells of a row by column."""
    cells = {
        "path_id": row.path_id,
        "return_period_years": row.return_period_years,
        "volume_m3": row.volume_m3,
        "extrapolated": int(bool(row.extrapolated)),
        **_design(row.design),
        **_lengths("", row),
        "p_left_profile": row.p_left_profile,
        "n_draws": row.n_draws,
        "interval": row.interval,
        "notes": " ".join(map(ENGLISH.alone, row.notes)),
    }
    for name in APART:
        if found := getattr(row, name):
            cells |= {**_lengths(f"{name}_", found), f"{name}_interval": found.interval}
    return cells


def _design(found: Design | None) -> dict[str, Any]:
    """The answer for a return period; nothing for a volume."""
    if found is None:
        return {}
    farthest, point = found.farthest_record, found.point
    return {
        **_lengths("design_", found, QUANTILES),
        "design_p_beyond": found.p_beyond,
        **({} if point is None else {f"design_{k}": v for k, v in point.to_dict().items()}),
        "farthest_record_x_m": None if farthest is None else farthest.runout_x_m,
        "farthest_record_date": None if farthest is None else farthest.date,
        "records_beyond": found.records_beyond,
        "n_records": found.n_records,
        "design_interval": found.interval,
    }


def _lengths(
    prefix: str, found: HazardRow | RunoutInterval | Design, statistics: Sequence[str] = STATISTICS
) -> dict[str, Any]:
    return {
        f"{prefix}{length}_{statistic}_m": getattr(getattr(found, f"{length}_m"), statistic)
        for length in ("runout_x", "runout_elevation")
        for statistic in statistics
    }


CREATOR = "avahazard"
NOT_IN_CELLS = re.compile(r"[\x00-\x08\x0b-\x1f]")  # a workbook with one of them does not open


def write_workbook(file: FilePath, sheets: Mapping[str, Sheet]) -> None:
    """Write tables by title as .xlsx: lengths in m, an empty cell beyond the profile.

    Numbers are numbers, and texts are texts, also those that begin like a formula.
    """
    from openpyxl import Workbook  # noqa: PLC0415 (slow to import)

    book = Workbook()
    book.properties.creator = CREATOR
    book.remove(book.active)
    for title, (columns, flat) in sheets.items():
        sheet = book.create_sheet(title)
        sheet.append(columns)
        for line, row in enumerate(flat, start=2):
            for column, name in enumerate(columns, start=1):
                value = row.get(name)
                if isinstance(value, str):
                    text = NOT_IN_CELLS.sub("\N{REPLACEMENT CHARACTER}", value)
                    sheet.cell(line, column, text).data_type = "s"
                elif value is not None:
                    sheet.cell(line, column, value)
        sheet.freeze_panes = "B2"
    book.save(file)


def is_own_workbook(file: FilePath) -> bool:
    """Whether `file` was made by `write_workbook`."""
    from openpyxl import load_workbook  # noqa: PLC0415 (slow to import)

    try:
        book = load_workbook(file, read_only=True)
    except Exception:
        return False
    own: bool = book.properties.creator == CREATOR and book.sheetnames[:1] == ["hazard"]
    book.close()
    return own
