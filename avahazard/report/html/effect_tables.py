"""Tables of the diagnosis: candidate effects, and what to measure next."""

from __future__ import annotations

from avahazard.report.html.effects_figure import SIGNIFICANT
from avahazard.report.html.table import HtmlTable, error_text
from avahazard.report.html.words import chance, likelier
from avahazard.report.language import ENGLISH, Language
from avahazard.results.diagnosis import Diagnosis


def candidates_table(diagnosis: Diagnosis, language: Language = ENGLISH) -> HtmlTable:
    """Candidate effects, best first; those that chance may have made are folded."""
    say, floor = language.say, 1.0 / (diagnosis.n_worlds + 1)
    named = set(diagnosis.missing)
    rows = [
        [
            language.effect(c.effect),
            likelier(c.screened_gain, language),
            chance(c.p_value, floor, language),
            error_text(c.error_before_m, diagnosis.coordinate, language),
            error_text(c.error_after_m, diagnosis.coordinate, language),
            ", ".join(language.effect(key) for key in c.confounded_with) or "–",
            language.told(c.physics),
        ]
        for c in diagnosis.candidates
    ]
    columns = (
        say("effect"), ">" + say("records likelier"), ">p", ">" + say("CRPS at best fit before"),
        ">" + say("after"), say("looks like"), say("meaning"),
    )  # fmt: skip
    shown = sum(c.effect in named or c.p_value <= SIGNIFICANT for c in diagnosis.candidates)
    return HtmlTable(
        "candidates",
        say("Candidate effects"),
        columns,
        rows,
        cards=True,
        shown=shown,
        folded=say("{n} that may be chance", n=len(rows) - shown),
    )


def measure_table(diagnosis: Diagnosis, language: Language = ENGLISH) -> HtmlTable | None:
    """What to measure next; None where nothing is proposed."""
    say = language.say
    rows = [
        [language.told(step.measurement), likelier(step.expected_gain, language)]
        for step in diagnosis.measure_next
    ]
    if not rows:
        return None
    columns = (say("measurement"), ">" + say("makes the right explanation likelier"))
    return HtmlTable("measure", say("What to measure next"), columns, rows)
