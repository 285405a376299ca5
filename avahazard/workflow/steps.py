"""One progress for work of several steps."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.results.base import Report


def steps(report: Report, weights: Sequence[float]) -> list[Report]:
    """A report for each step that tells `report` of the whole: step k is `weights[k]` of it.

    The whole goes from 0 to 1 and never back, whatever a step tells of itself.
    """
    whole = float(sum(weights))
    return [
        _step(report, sum(weights[:k]) / whole, weight / whole) for k, weight in enumerate(weights)
    ]


def _step(report: Report, start: float, weight: float) -> Report:
    def tell(what: str, done: float, total: float) -> None:
        share = min(max(done / total, 0.0), 1.0) if total > 0.0 else 0.0
        report(what, start + weight * share, 1.0)

    return tell
