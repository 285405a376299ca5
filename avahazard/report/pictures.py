"""How results are drawn to a file; matplotlib loads when a picture is drawn."""

from __future__ import annotations

from pathlib import Path

from avahazard.results.base import PICTURES
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.friction import Frictions
from avahazard.results.ladder import Ladder


def _comparison(file: Path, found: Comparison) -> None:
    from avahazard.report.comparison_figure import draw_comparison  # noqa: PLC0415 (slow)

    draw_comparison(file, found)


def _diagnosis(file: Path, found: Diagnosis) -> None:
    from avahazard.report.diagnosis_figure import draw_diagnosis  # noqa: PLC0415 (slow)

    draw_diagnosis(file, found)


def _ladder(file: Path, found: Ladder) -> None:
    from avahazard.report.ladder_figure import draw_ladder  # noqa: PLC0415 (slow)

    draw_ladder(file, found.rows)


def _frictions(file: Path, found: Frictions) -> None:
    from avahazard.report.friction_figure import draw_densities  # noqa: PLC0415 (slow)

    draw_densities(file, found.density)


PICTURES.update(
    {
        Comparison: _comparison,
        Diagnosis: _diagnosis,
        Ladder: _ladder,
        Frictions: _frictions,
    }
)
