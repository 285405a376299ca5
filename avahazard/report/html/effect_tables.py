"""Tables of the diagnosis: candidate effects, and what to measure next."""

from __future__ import annotations

from avahazard.report.html.effects_figure import SIGNIFICANT
from avahazard.report.html.table import HtmlTable, error_text
from avahazard.report.html.words import chance, likelier
from avahazard.results.diagnosis import Diagnosis


def candidates_table(diagnosis: Diagnosis) -> HtmlTable:
    """Candidate effects, best first; those that chance may have made are folded."""
    floor = 1.0 / (diagnosis.n_worlds + 1)
    named = set(diagnosis.missing)
    rows = [
        [
            c.effect,
            likelier(c.screened_gain),
            chance(c.p_value, floor),
            error_text(c.error_before_m, diagnosis.coordinate),
            error_text(c.error_after_m, diagnosis.coordinate),
            ", ".join(c.confounded_with) or "–",
            c.physics,
        ]
        for c in diagnosis.candidates
    ]
    columns = (
        "effect", ">records likelier", ">p", ">own CRPS before", ">after", "looks like", "meaning"
    )  # fmt: skip
    shown = sum(c.effect in named or c.p_value <= SIGNIFICANT for c in diagnosis.candidates)
    folded = f"{len(rows) - shown} that may be chance"
    return HtmlTable(
        "candidates", "Candidate effects", columns, rows, cards=True, shown=shown, folded=folded
    )


def measure_table(diagnosis: Diagnosis) -> HtmlTable | None:
    """What to measure next; None where nothing is proposed."""
    rows = [[step.measurement, likelier(step.expected_gain)] for step in diagnosis.measure_next]
    if not rows:
        return None
    columns = ("measurement", ">makes the right explanation likelier")
    return HtmlTable("measure", "What to measure next", columns, rows)
