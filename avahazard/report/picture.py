"""Pictures without a screen, into a file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = (".png", ".svg", ".pdf")


@contextmanager
def picture(file: Path) -> Iterator[Axes]:
    """Give axes to draw on; the picture is written to `file` at the end.

    Raises:
        AvahazardError: the name does not end in one of `FORMATS`.
    """
    if file.suffix.lower() not in FORMATS:
        raise AvahazardError(
            f"{file} is not the name of a picture.", f"It must end in {', '.join(FORMATS)}."
        )
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 (slow)
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    yield figure.add_subplot()
    figure.savefig(file, dpi=150)
