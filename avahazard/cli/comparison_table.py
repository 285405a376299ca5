"""Scores and failures as people read them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from avahazard.results.comparison import Comparison, HeldOutScores, Scores
from avahazard.results.prediction import PredictionScores

MOST_LINES = 6
SIGNIFICANT = 0.05


def show_scores(
    *parts: tuple[str, Scores | HeldOutScores | PredictionScores],
) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Columns and rows of a table of scores: a row of runouts, and of speeds if any, each."""
    rows: list[tuple[Any, ...]] = []
    for name, scores in parts:
        for what, unit in (("runout", "m"), ("speed", "m_s")):
            found = getattr(scores, what)
            if found is not None:
                rows.append(
                    (
                        name,
                        f"{what}, {unit.replace('_', '/')}",
                        found.n,
                        *(
                            f"{getattr(found, f'{key}_{unit}'):.1f}"
                            for key in ("rmse", "bias", "crps")
                        ),
                        f"{found.coverage_50:.0%}",
                        f"{found.coverage_90:.0%}",
                    )
                )
    return ("", "of", ">n", ">RMSE", ">bias", ">CRPS", ">in 50 %", ">in 90 %"), rows


def failures(comparison: Comparison) -> Iterator[str]:
    """The worst axes in words, significant ones only, or that there is none."""
    worst = [row for row in comparison.where_it_fails if row.p_value < SIGNIFICANT]
    if not worst:
        yield "nowhere that chance could not explain (corrected p > 0.05 on every axis)."
    for row in worst[:MOST_LINES]:
        yield (
            f"{row.axis}, {row.level} ({row.n} events): recorded "
            f"{_direction(comparison.coordinate, row.bias_m)}, {_chance(row.p_value)}."
        )
    if len(worst) > MOST_LINES:
        yield f"and on {len(worst) - MOST_LINES} levels more (--json has them all)."


def _direction(coordinate: str, bias: float) -> str:
    """Where the records lie against the prediction."""
    size = f"{abs(bias):.0f} m"
    if coordinate == "elevation":
        return f"{size} {'lower' if bias > 0 else 'higher'} than predicted"
    if coordinate == "mixed":
        return f"{size} {'farther down' if bias > 0 else 'less far down'} than predicted"
    return f"{size} {'shorter' if bias > 0 else 'farther'} than predicted"


def _chance(p: float) -> str:
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"
