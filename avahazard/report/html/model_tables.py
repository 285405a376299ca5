"""Tables of the model: its parameters, scores and failures, and how it was made."""

from __future__ import annotations

import math
from collections.abc import Mapping

from avahazard.report.html.content import ReportContent
from avahazard.report.html.summary import SIGNIFICANT, failing
from avahazard.report.html.table import HtmlTable, error_text
from avahazard.report.html.words import (
    COORDINATES,
    axis_words,
    chance,
    integer,
    number,
    share,
    unit_words,
)
from avahazard.results.amounts import RATIO, amount, bare
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison


def ladder_table(content: ReportContent) -> HtmlTable:
    """Every model and its error, oldest first."""
    rows = [
        [
            row.model,
            row.parent or "–",
            ", ".join(row.added) or "–",
            *(
                error_text(getattr(row, key), known)
                for key, known in (
                    ("held_out_crps_m", row.coordinate),
                    ("held_out_crps_x_m", "x"),
                    ("crps_m", row.coordinate),
                )
            ),
            "–" if row.elpd_loo is None else f"{row.elpd_loo:.0f}".replace("-", "−"),
            "–" if row.coverage_90 is None else share(row.coverage_90),
            "–" if row.speed_rmse_m_s is None else f"{row.speed_rmse_m_s:.1f} m/s",
        ]
        for row in content.ladder
    ]
    columns = (
        "model", "from", "added", ">error", ">in x", ">on its own records", ">elpd", ">in 90 %",
        ">speed RMSE",
    )  # fmt: skip
    return HtmlTable("models", "Every model and its error, oldest first", columns, rows)


def scores_table(comparison: Comparison) -> HtmlTable:
    """Scores on what the model was calibrated on, and on what was kept back."""
    held = comparison.held_out
    apart = "paths kept back" if held.by == "path" else "fifths of the events kept back"
    rows = []
    coordinate = comparison.coordinate
    for name, scores in ((apart, held), ("records of the calibration", comparison.scores)):
        for what, unit, found in ((COORDINATES[coordinate], "m", scores.runout),
                                  (COORDINATES["x"], "m",
                                   None if coordinate == "x" else scores.runout_x),
                                  ("speed", "m_s", scores.speed)):  # fmt: skip
            if found is not None:
                in_ratio = unit == "m" and coordinate == RATIO
                ending = "H/L" if in_ratio else unit.replace("_", "/")
                rows.append(
                    [
                        name,
                        what,
                        str(found.n),
                        *(
                            f"{_signed(getattr(found, f'{key}_{unit}'), in_ratio)} {ending}"
                            for key in ("rmse", "bias", "crps")
                        ),
                        share(found.coverage_50),
                        share(found.coverage_90),
                    ]
                )
    columns = ("", "of", ">n", ">RMSE", ">bias", ">CRPS", ">in 50 %", ">in 90 %")
    return HtmlTable("scores", "Scores against the records", columns, rows)


def failures_table(comparison: Comparison, names: Mapping[str, str]) -> HtmlTable:
    """Where the model fails, the least likely by chance first; what may be chance is folded."""
    n_failing = len(failing(comparison))
    rows = [
        [
            axis_words(row.axis),
            names.get(row.level, row.level),
            str(row.n),
            ("+" if row.bias_m > 0 else "")
            + amount(row.bias_m, comparison.coordinate, 0).replace("-", "−"),
            chance(row.p_value),
            "beyond chance" if row.p_value < SIGNIFICANT else "may be chance",
        ]
        for row in sorted(comparison.where_it_fails, key=lambda row: row.p_value >= SIGNIFICANT)
    ]
    columns = ("by", "level", ">events", ">predicted less recorded", ">p", "")
    folded = f"{len(rows) - n_failing} that may be chance"
    return HtmlTable("failures", "Where it fails", columns, rows, shown=n_failing, folded=folded)


def parameters_table(model: Calibration) -> HtmlTable:
    """The posterior of the parameters in numbers."""
    rows = [
        [
            name,
            *(_as_sure_as(p.sd, getattr(p, key)) for key in ("mean", "sd", "q05", "q95", "mode")),
            unit_words(p.unit) or "–",
        ]
        for name, p in model.parameters.items()
        if not name.startswith("path:")
    ]
    columns = ("", ">mean", ">± sd", ">5 %", ">95 %", ">mode", "unit")
    return HtmlTable("parameters", "Parameters", columns, rows)


def made_table(content: ReportContent) -> HtmlTable:
    """Seeds, versions and fingerprint: what somebody needs to make all this again."""
    model = content.model
    checks = model.diagnostics
    rhat = checks.rhat_max
    rows = [
        ["calibrated (UTC)", content.created],
        [
            "method",
            f"{model.method}, {model.chains} chains of {integer(model.draws)} draws",
        ],
        ["seed", str(model.seed)],
        [
            "convergence",
            f"R-hat {'infinite' if rhat is None else f'{rhat:.3f}'}, effective sample size at "
            f"least {integer(checks.ess_bulk_min)}, {share(checks.acceptance)} accepted",
        ],
        ["fingerprint of the records (SHA-256)", model.data_fingerprint],
    ]
    if content.calibrated_paths:
        rows.append(["calibrated on the paths", ", ".join(content.calibrated_paths)])
    if content.effect_sha256:
        rows.append(["fingerprint of the effect file (SHA-256)", content.effect_sha256])
    if content.diagnosis is not None:
        rows.append(
            [
                "diagnosis",
                f"{content.diagnosis.n_worlds} made worlds, seed {content.diagnosis.seed}",
            ]
        )
    draws = sorted({row["n_draws"] for row in content.rows})
    if draws:
        rows.append(["draws of the bounds", ", ".join(integer(n) for n in draws) + " for each row"])
    rows += [[f"version of {name}", version] for name, version in content.versions.items()]
    return HtmlTable("made", "How to make it again", ("", ""), rows)


def _signed(value: float, in_ratio: bool) -> str:
    """One decimal, of H/L four; nothing is less than nothing by nothing."""
    text = bare(value, RATIO if in_ratio else None)
    return text.lstrip("-") if float(text) == 0.0 else text.replace("-", "−")


def _as_sure_as(sd: float, value: float) -> str:
    """The value with as many decimals as two digits of its standard deviation have."""
    decimals = 1 - math.floor(math.log10(sd)) if sd > 0.0 else 0
    if 0 <= decimals < 6 and abs(value) < 1e6:
        return f"{value:.{decimals}f}".replace("-", "−")
    return number(value)
