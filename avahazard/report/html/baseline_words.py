"""Where the α-β runouts and the design runouts part, in words."""

from __future__ import annotations

from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.front import shown_period


def baseline_words(content: ReportContent) -> list[str]:
    """On which paths α-β and the model disagree, and what that means; where it has no answer."""
    say, told = content.language.say, content.language.told
    period = shown_period(content)
    shorter: list[str] = []
    farther: list[str] = []
    for view in content.paths:
        design = _design(view, period)
        for row in view.alpha_beta if design is not None else ():
            side = _side(row, design or {})
            if side:
                named = f"{view.name} ({told(row['coefficients'])})"
                (shorter if side < 0 else farther).append(named)
    words = []
    if shorter:
        words.append(
            say(
                "Shorter than all that the design runout may be, 9 times in 10: {paths}.",
                paths=", ".join(shorter),
            )
        )
    if farther:
        words.append(
            say(
                "Farther than all that the design runout may be, 9 times in 10: {paths}.",
                paths=", ".join(farther),
            )
        )
    if shorter or farther:
        words.append(
            say(
                "There the records of the path say something else than its ground. α-β is the "
                "mean of extreme avalanches of another region on ground of that shape: where "
                "records are many, they weigh more; where they are few, look at both."
            )
        )
    without = [v.name for v in content.paths if any(r["beta_deg"] is None for r in v.alpha_beta)]
    if without:
        words.append(
            say(
                "No β-point: {paths}. The profile never flattens to 10°, where β is measured, so "
                "that α-β has no answer there.",
                paths=", ".join(without),
            )
        )
    return words


def _design(view: PathView, period: float | None) -> Document | None:
    rows = (r for r in view.rows if r.get("design") and r["return_period_years"] == period)
    return next((row["design"] for row in rows), None)


def _side(row: Document, design: Document) -> int:
    """−1 where α-β with one standard deviation lies short of the 90 %, 1 beyond it, else 0."""
    found, x = row["runout_x_m"], design["runout_x_m"]
    low, high = row["runout_x_low_m"], row["runout_x_high_m"]
    if found is None:
        return 0
    if high is not None and x["q05"] is not None and high < x["q05"]:
        return -1
    return 1 if low is not None and x["q95"] is not None and low > x["q95"] else 0
