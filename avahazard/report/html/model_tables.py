"""Tables of the model: its parameters, scores and failures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avahazard.criticism.screening.significance import LEVEL
from avahazard.report.html.content import ReportContent
from avahazard.report.html.summary import SIGNIFICANT, failing
from avahazard.report.html.words import (
    amount,
    axis_words,
    chance,
    coordinate_words,
    integer,
    level_words,
    likelier,
    number,
    share,
    unit_words,
)
from avahazard.report.language import ENGLISH, Language
from avahazard.results.base import RATIO, bare
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Diagnosis


@dataclass(frozen=True, slots=True)
class HtmlTable:
    """Columns (a name that begins with '>' is set to the right) and rows of text.

    `cards`: on a narrow screen every row becomes a block of its own, with a line for each cell.
    Rows after the first `shown` are folded under the words `folded`; None: no row is.
    """

    key: str
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    cards: bool = False
    shown: int | None = None
    folded: str = ""

    @property
    def parts(self) -> list[tuple[bool, Sequence[Sequence[str]]]]:
        """The rows that are always seen, and those that are folded, each if there are any."""
        k = len(self.rows) if self.shown is None else self.shown
        parts = [(False, self.rows[:k]), (True, self.rows[k:])]
        return [part for part in parts if part[1]]


def error_text(
    value: float | None, coordinate: str | None = None, language: Language = ENGLISH
) -> str:
    """An error in metres, or H/L in that coordinate; a dash where it is not known."""
    return "–" if value is None else amount(value, coordinate, language=language)


def made_table(content: ReportContent) -> HtmlTable:
    """Seeds, versions and fingerprints."""
    model, language = content.model, content.language
    say, checks = language.say, content.model.diagnostics
    rhat = checks.rhat_max
    day, _, hour = content.created.partition("T")
    created = content.created
    if language.date(day) != day:
        created = f"{language.date(day)} {hour.removesuffix('Z')}"
    rows = [
        [say("calibrated (UTC)"), created],
        [
            say("method"),
            say(
                "{method}, {n} chains of {draws} draws",
                method=model.method,
                n=model.chains,
                draws=integer(model.draws, language),
            ),
        ],
        [say("seed"), str(model.seed)],
        [
            say("convergence"),
            say(
                "R-hat {rhat}, effective sample size at least {ess}, {share} accepted",
                rhat=say("infinite") if rhat is None else language.number(f"{rhat:.3f}"),
                ess=integer(checks.ess_min, language),
                share=share(checks.acceptance, language),
            ),
        ],
        [say("fingerprint of the records (SHA-256)"), model.data_fingerprint],
    ]
    if content.calibrated_paths:
        rows.append([say("calibrated on the paths"), ", ".join(content.calibrated_paths)])
    if content.effect_sha256:
        rows.append([say("fingerprint of the effect file (SHA-256)"), content.effect_sha256])
    if content.diagnosis is not None:
        rows.append(
            [
                say("diagnosis"),
                say(
                    "{n} made worlds, seed {seed}",
                    n=content.diagnosis.n_worlds,
                    seed=content.diagnosis.seed,
                ),
            ]
        )
    draws = sorted({row["n_draws"] for row in content.rows})
    if draws:
        each = ", ".join(integer(n, language) for n in draws)
        rows.append([say("draws of the bounds"), say("{n} for each row", n=each)])
    rows += [
        [say("version of {name}", name=name), version] for name, version in content.versions.items()
    ]
    return HtmlTable("made", say("How to make it again"), ("", ""), rows)


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
            language.say(c.physics),
        ]
        for c in diagnosis.candidates
    ]
    columns = (
        say("effect"), ">" + say("records likelier"), ">p", ">" + say("CRPS at best fit before"),
        ">" + say("after"), say("looks like"), say("meaning"),
    )  # fmt: skip
    shown = sum(c.effect in named or c.p_value <= LEVEL for c in diagnosis.candidates)
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
        [language.note(step.measurement), likelier(step.expected_gain, language)]
        for step in diagnosis.measure_next
    ]
    if not rows:
        return None
    columns = (say("measurement"), ">" + say("makes the right explanation likelier"))
    return HtmlTable("measure", say("What to measure next"), columns, rows)


def ladder_table(content: ReportContent) -> HtmlTable:
    """Every model and its error, oldest first."""
    language, say = content.language, content.language.say
    rows = [
        [
            row.model,
            row.parent or "–",
            ", ".join(language.effect(key) for key in row.added) or "–",
            *(
                error_text(getattr(row, key), known, language)
                for key, known in (
                    ("held_out_crps_m", row.coordinate),
                    ("held_out_crps_x_m", "x"),
                    ("crps_m", row.coordinate),
                )
            ),
            "–" if row.elpd_loo is None else language.number(f"{row.elpd_loo:.0f}"),
            "–" if row.coverage_90 is None else share(row.coverage_90, language),
            "–" if row.speed_rmse_m_s is None else language.number(f"{row.speed_rmse_m_s:.1f} m/s"),
        ]
        for row in content.ladder
    ]
    columns = (
        say("model"), say("from"), say("added"), ">" + say("error"), ">" + say("in x"),
        ">" + say("on its own records"), ">elpd", ">" + say("in 90 %"), ">" + say("speed RMSE"),
    )  # fmt: skip
    return HtmlTable("models", say("Every model and its error, oldest first"), columns, rows)


def scores_table(comparison: Comparison, language: Language = ENGLISH) -> HtmlTable:
    """Scores on what the model was calibrated on, and on what was kept back."""
    say, held = language.say, comparison.held_out
    apart = say("paths kept back") if held.by == "path" else say("fifths of the events kept back")
    rows = []
    coordinate = comparison.coordinate
    for name, scores in ((apart, held), (say("records of the calibration"), comparison.scores)):
        for what, unit, found in (
            (coordinate_words(coordinate, language), "m", scores.runout),
            (coordinate_words("x", language), "m",
             None if coordinate == "x" else scores.runout_x),
            (say("speed"), "m_s", scores.speed),
        ):  # fmt: skip
            if found is not None:
                in_ratio = unit == "m" and coordinate == RATIO
                ending = "H/L" if in_ratio else unit.replace("_", "/")
                rows.append(
                    [
                        name,
                        what,
                        str(found.n),
                        *(
                            f"{_signed(getattr(found, f'{key}_{unit}'), in_ratio, language)} "
                            f"{ending}"
                            for key in ("rmse", "bias", "crps")
                        ),
                        share(found.coverage_50, language),
                        share(found.coverage_90, language),
                    ]
                )
    columns = (
        "", say("of"), ">n", ">RMSE", ">" + say("bias"), ">CRPS", ">" + say("in 50 %"),
        ">" + say("in 90 %"),
    )  # fmt: skip
    return HtmlTable("scores", say("Scores against the records"), columns, rows)


def failures_table(
    comparison: Comparison, names: Mapping[str, str], language: Language = ENGLISH
) -> HtmlTable:
    """Where the model fails, the least likely by chance first; what may be chance is folded."""
    say, n_failing = language.say, len(failing(comparison))
    rows = [
        [
            axis_words(row.axis, language),
            names[row.level] if row.level in names else level_words(row.level, language),
            str(row.n),
            ("+" if row.bias_m > 0 else "")
            + amount(row.bias_m, comparison.coordinate, 0, language),
            chance(row.p_value, language=language),
            say("beyond chance") if row.p_value < SIGNIFICANT else say("may be chance"),
        ]
        for row in sorted(comparison.where_it_fails, key=lambda row: row.p_value >= SIGNIFICANT)
    ]
    columns = (
        say("by"), say("level"), ">" + say("events"), ">" + say("predicted less recorded"), ">p",
        "",
    )  # fmt: skip
    folded = say("{n} that may be chance", n=len(rows) - n_failing)
    title = say("Where it fails")
    return HtmlTable("failures", title, columns, rows, shown=n_failing, folded=folded)


def parameters_table(model: Calibration, language: Language = ENGLISH) -> HtmlTable:
    """The posterior of the parameters in numbers."""
    say = language.say
    rows = [
        [
            name,
            *(
                _as_sure_as(p.sd, getattr(p, key), language)
                for key in ("mean", "sd", "q05", "q95", "mode")
            ),
            unit_words(p.unit, language) or "–",
        ]
        for name, p in model.parameters.items()
        if not name.startswith("path:")
    ]
    columns = (
        "", ">" + say("mean"), ">" + say("± sd"), ">5 %", ">95 %", ">" + say("mode"), say("unit"),
    )  # fmt: skip
    return HtmlTable("parameters", say("Parameters"), columns, rows)


def _signed(value: float, in_ratio: bool, language: Language) -> str:
    """One decimal, of H/L four; nothing is less than nothing by nothing."""
    text = bare(value, RATIO if in_ratio else None)
    return language.number(text.lstrip("-") if float(text) == 0.0 else text)


def _as_sure_as(sd: float, value: float, language: Language) -> str:
    """The value with as many decimals as two digits of its standard deviation have."""
    decimals = 1 - math.floor(math.log10(sd)) if sd > 0.0 else 0
    if 0 <= decimals < 6 and abs(value) < 1e6:
        return language.number(f"{value:.{decimals}f}")
    return number(value, language)
