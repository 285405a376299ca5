"""Tables of the diagnosis: candidate effects, and what to measure next."""

from __future__ import annotations

from avahazard.report.html.table import HtmlTable, error_text
from avahazard.report.html.words import chance
from avahazard.results.diagnosis import Diagnosis

MOST_CANDIDATES = 16


def candidates_table(diagnosis: Diagnosis) -> HtmlTable:
    """Candidate effects, best first."""
    rows = [
        [
            c.effect,
            f"{c.gain:.1f}".replace("-", "−"),
            chance(c.p_value),
            error_text(c.error_before_m),
            error_text(c.error_after_m),
            ", ".join(c.confounded_with) or "–",
            c.physics,
        ]
        for c in diagnosis.candidates[:MOST_CANDIDATES]
    ]
    columns = ("effect", ">gain, nats", ">p", ">own CRPS before", ">after", "looks like", "meaning")
    return HtmlTable("candidates", "Candidate effects", columns, rows, cards=True)


def measure_table(diagnosis: Diagnosis) -> HtmlTable | None:
    """What to measure next; None where nothing is proposed."""
    rows = [[step.measurement, f"{step.expected_gain:.1f} nats"] for step in diagnosis.measure_next]
    if not rows:
        return None
    return HtmlTable("measure", "What to measure next", ("measurement", ">expected gain"), rows)
