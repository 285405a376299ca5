"""Where α-β and the design runout part, in words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from avahazard.report.html.content import ReportContent
from avahazard.report.html.front import shown_period
from avahazard.report.html.unknowns import baseline_words


def said(content: ReportContent, **runout: Any) -> str:
    view = next(v for v in content.paths if v.rows and v.alpha_beta)
    row = {"coefficients": "norway", "beta_deg": 25.0, **runout}
    changed = replace(view, alpha_beta=[row])
    return " ".join(baseline_words(replace(content, paths=(changed,), rows=view.rows)))


def test_it_says_on_which_side_they_part(content: ReportContent) -> None:
    view = next(v for v in content.paths if v.rows and v.alpha_beta)
    period = shown_period(content)
    x = next(r for r in view.rows if r["return_period_years"] == period)["design"]["runout_x_m"]
    at = {"runout_x_m": x["q50"], "runout_x_low_m": x["q05"], "runout_x_high_m": x["q95"]}
    assert said(content, **at) == ""
    near = dict.fromkeys(at, 1.0)
    assert "Shorter than all" in said(content, **near)
    if x["q95"] is not None:
        far = dict.fromkeys(at, x["q95"] + 100000.0)
        assert "Farther than all" in said(content, **far)


def test_no_beta_point_is_explained(content: ReportContent) -> None:
    none = {"runout_x_m": None, "runout_x_low_m": None, "runout_x_high_m": None, "beta_deg": None}
    assert "No β-point" in said(content, **none)
