"""Bounds of the runout as Parquet, in pieces: a country's fit into little memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from itertools import islice
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from avahazard.records.errors import AvahazardError
from avahazard.report.hazard_csv import hazard_cells
from avahazard.results.hazard import HazardRow

if TYPE_CHECKING:
    import pyarrow as pa

CREATOR = b"avahazard"
PIECE = 2000
"""Rows that are written together."""
GEOMETRY = "geometry"


def require_parquet() -> None:
    """Raise `AvahazardError` where pyarrow is not installed."""
    if find_spec("pyarrow") is None:
        raise AvahazardError(
            "Files of Parquet need the package pyarrow, which is not installed.",
            "Install it: pip install 'avahazard[parquet]'; or export to .csv.",
        )


def write_hazard_parquet(
    file: FilePath, rows: Callable[[], Iterable[HazardRow]]
) -> tuple[int, int]:
    """Write the rows of `hazard` as Parquet.

    Returns how many they are, and how many have a place on the map. Columns are those of the CSV,
    lengths in m, null beyond the profile; the places of design runouts are the column `geometry`
    (GeoParquet). `rows` gives the rows anew at each call.
    """
    import pyarrow as pa  # noqa: PLC0415 (may be missing)
    from pyarrow import parquet  # noqa: PLC0415

    fields: dict[str, pa.DataType] = {}
    systems: dict[str, None] = {}
    n_rows = n_places = 0
    for cells in map(hazard_cells, rows()):
        n_rows += 1
        for name, value in cells.items():
            fields.setdefault(name, pa.float64())
            if isinstance(value, str):
                fields[name] = pa.string()
        if "design_crs" in cells:
            systems[cells["design_crs"]] = None
            n_places += 1
    about = {b"creator": CREATOR}
    wkb = None
    if systems:
        from avahazard.gis import require_packages  # noqa: PLC0415

        require_packages()
        from avahazard.gis.map_files import point_column  # noqa: PLC0415 (may be missing)

        wkb, geo = point_column(list(systems))
        about[b"geo"] = geo.encode()
        fields[GEOMETRY] = pa.binary()
    schema = pa.schema(list(fields.items()), metadata=about)
    with parquet.ParquetWriter(file, schema) as writer:
        for piece in _pieces(map(hazard_cells, rows())):
            for cells in piece:
                if wkb is not None and "design_crs" in cells:
                    place = (cells["design_x"], cells["design_y"], cells["design_crs"])
                    cells[GEOMETRY] = wkb(place)
            writer.write_table(pa.Table.from_pylist(piece, schema))
    return n_rows, n_places


def is_own_parquet(file: FilePath) -> bool:
    """Whether `file` was made by `write_hazard_parquet`."""
    from pyarrow import ArrowException, parquet  # noqa: PLC0415 (may be missing)

    try:
        about = parquet.read_schema(file).metadata or {}
    except (ArrowException, OSError):
        return False
    return about.get(b"creator") == CREATOR


def _pieces(cells: Iterable[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
    there = iter(cells)
    while piece := list(islice(there, PIECE)):
        yield piece
