"""Few draws, for tests of what is reported, not of how exact it is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

FEW: dict[str, object] = {
    "avahazard.workflow.compare.RECORD_DRAWS": 200,
    "avahazard.workflow.report.RECORD_DRAWS": 200,
    "avahazard.workflow.report_loop.RECORD_DRAWS": 200,
    "avahazard.criticism.scoring.error_budget.N_DRAWS": 120,
    "avahazard.criticism.scoring.error_budget.N_TABLES": 4,
    "avahazard.criticism.scoring.loo.MAX_DRAWS": 200,
    "avahazard.criticism.scoring.held_out.RECORD_DRAWS": 60,
    "avahazard.criticism.scoring.held_out.DENSITY_DRAWS": 60,
    "avahazard.inference.prediction.MAX_TABLES": 4,
    "avahazard.hazard.path_hazard.MAX_TABLES": 8,
}


@contextmanager
def few_draws() -> Iterator[None]:
    """Let comparisons and reports draw little; what is made once for all tests must not."""
    with pytest.MonkeyPatch.context() as patch:
        for place, n in FEW.items():
            patch.setattr(place, n)
        yield
