"""Pictures without a screen, into a file; matplotlib loads when one is drawn.

What draws to a file raises `AvahazardError` where its name does not end in one of `FORMATS`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avahazard.records.errors import AvahazardError
from avahazard.results.base import PICTURES, Draw
from avahazard.results.comparison import Comparison, Ladder
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.friction import Frictions
from avahazard.whole_file import written_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")


@contextmanager
def figure(file: Path, size_in: tuple[float, float] = (8.0, 5.0)) -> Iterator[Figure]:
    """Give an empty figure of that size (inches), written to `file` at the end."""
    require_picture(file)
    from matplotlib.figure import Figure  # noqa: PLC0415 (slow)

    drawn = Figure(figsize=size_in, layout="constrained")
    yield drawn
    with written_whole(file) as part:
        drawn.savefig(part, dpi=150)


def require_picture(file: Path | None) -> None:
    """Raise `AvahazardError` where `file`, if any, is no name of a picture: before long work."""
    if file is not None and file.suffix.lower() not in FORMATS:
        raise AvahazardError(
            f"{file} is not the name of a picture.", f"It must end in {', '.join(FORMATS)}."
        )


def _draw_result(file: Path, found: Any) -> None:
    from avahazard.report import figure_pictures as pictures  # noqa: PLC0415 (slow)
    from avahazard.report.plots import draw_frictions  # noqa: PLC0415 (slow)

    draw: dict[type, Draw] = {
        Comparison: pictures.draw_comparison,
        Diagnosis: pictures.draw_diagnosis,
        Ladder: pictures.draw_ladder,
        Frictions: draw_frictions,
    }
    draw[type(found)](file, found)


PICTURES.update(dict.fromkeys((Comparison, Diagnosis, Ladder, Frictions), _draw_result))
