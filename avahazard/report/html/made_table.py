"""The table of how the report was made: what somebody needs to make all this again."""

from __future__ import annotations

from avahazard.report.html.content import ReportContent
from avahazard.report.html.table import HtmlTable
from avahazard.report.html.words import integer, share


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
