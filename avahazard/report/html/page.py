"""The page: figures, tables and words put into the template."""

from __future__ import annotations

import base64
import hashlib
import re
from collections import defaultdict
from collections.abc import Iterator
from importlib.resources import files
from operator import itemgetter
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from avahazard.report import model_tables, tables
from avahazard.report.html import annex, brief, model_figures, record_figures, score_figures
from avahazard.report.html.content import PathView, ReportContent
from avahazard.report.html.figure import Figure, script_json
from avahazard.report.html.map_figure import map_figure
from avahazard.report.html.path_figure import path_figure
from avahazard.report.html.vector_pictures import overview_map
from avahazard.report.language import plural, say, spoken
from avahazard.report.sentences import error_text, model_text, verdict_text, why_text
from avahazard.report.words import events, integer, paths, share

UNIT = re.compile(
    r"(?<=\d) (?=(?:m[²³]?|m/s|kPa|nats)(?!\w))|(?<=\d) ?(?=%)| (?=[:;?!»×])|(?<=×) |(?<=«) "
)
DATE = re.compile(r"\b(\d{4})-(\d\d)-(\d\d)\b")


def switch_json(content: ReportContent) -> Markup:
    """The models that the page switches between, and the error of each."""
    loop = content.loop
    value = {
        "own": loop.lineage[-1],
        "language": _language(),
        "models": [state.key for state in loop.models],
        "states": {
            state.key: {key: getattr(state, key) for key in ("held_out_m", "crps_m", "rmse_m")}
            for state in loop.models
        },
    }
    return script_json(value)


def _language() -> dict[str, Any]:
    """Signs of numbers, the words of the script, and those of Plotly's toolbar."""
    return {
        "code": spoken().code,
        "decimal": spoken().decimal,
        "separators": spoken().decimal + spoken().group,
        "shown": say(
            "Shown: {model}. In-sample CRPS {crps}, root mean square error {rmse}; held-out "
            "{held_out}."
        ),
        "toolbar": {
            "Download plot as a PNG": say("Download plot as a PNG"),
            "Download plot": say("Download plot as a PNG"),
            "Zoom": say("Zoom"),
            "Pan": say("Pan"),
            "Zoom in": say("Zoom in"),
            "Zoom out": say("Zoom out"),
            "Reset axes": say("Reset axes"),
        },
    }


def render(content: ReportContent) -> str:
    """The whole report as HTML that needs nothing else: no network, no other file.

    It is in the language that is spoken.
    """
    folder = files("avahazard.report.html") / "templates"
    model = content.model
    n_paths = len({e.path_id for e in content.events if e.path_id is not None})
    cards, common = brief.path_cards(content)
    period = brief.shown_period(content)
    shown = [row for row in content.rows if row.return_period_years == period]
    values = {
        "content": content,
        "annex": annex,
        "brief": brief,
        "language": spoken(),
        "by_text": _by_text(content),
        "conclusion": brief.conclusion(content),
        "map": overview_map(content, period),
        "cards": cards,
        "common": common,
        "zoned": any(view.drawn_zones for view in content.paths),
        "period": period,
        "design": tables.design_table(shown, content.names),
        "model_text": model_text(model, n_paths),
        "why_text": why_text(model.model, list(content.ladder)),
        "error_text": [] if content.comparison is None else error_text(content.comparison),
        "style": Markup((folder / "report.css").read_text(encoding="utf-8")),  # noqa: S704 (our own)
    }
    script = ""
    if not content.brief:
        script = _plotly() + "\n" + (folder / "report.js").read_text(encoding="utf-8")
        diagnosis, names = content.diagnosis, content.names
        values |= {
            "chapters": annex.chapters(content),
            "verdict": None if diagnosis is None else verdict_text(diagnosis, None),
            "figures": _figures(content, names),
            "posterior": model_figures.posterior_figures(model.parameters, content.draws),
            "predicted": record_figures.predicted_figures(content.events, names, content.loop),
            "switch": switch_json(content),
            "sections": list(_sections(content)),
            "tables": _tables(content, names),
        }
    code = Markup(script)  # noqa: S704 (our own)
    template = _environment().get_template("report.html.j2")
    return template.render(values, script=code, script_hash=_hash(script))


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("avahazard.report.html", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        extensions=["jinja2.ext.i18n"],
        finalize=kept_together,
    )
    # What the extension adds to an environment is not in its types.
    translations: Any = environment
    translations.install_gettext_callables(say, plural)
    return environment


def kept_together(value: Any) -> Any:
    """Text with numbers and units, and dates, each on one line; HTML as it is."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    return DATE.sub("\\1\u2011\\2\u2011\\3", UNIT.sub("\u00a0", value))


def _by_text(content: ReportContent) -> str:
    """Under the title: which model, on how much."""
    model = content.model
    return say(
        "Model “{model}”, calibrated {date} on {events}; {paths}.",
        model=model.model,
        date=spoken().date(content.created[:10]),
        events=events(len(content.events)),
        paths=paths(len(content.paths)),
    )


def _figures(content: ReportContent, names: dict[str, str]) -> dict[str, Figure | None]:
    """The figures that stand by their names; None where there is nothing to draw."""
    comparison, diagnosis = content.comparison, content.diagnosis
    friction = content.friction
    force = () if comparison is None else comparison.measured_force
    return {
        "record": record_figures.record_figure(content.events, content.paths),
        "ladder": score_figures.ladder_figure(content.ladder, content.model.model),
        "friction": None
        if friction is None
        else model_figures.friction_figure(friction, content.events, names),
        "density": model_figures.density_figure(content.densities, names),
        "residuals": record_figures.residuals_figure(content.events, names, content.loop),
        "failed": record_figures.failed_figure(content.events, names, content.loop),
        "force_shape": record_figures.force_shape_figure(content.events, names, content.loop),
        "suspect": record_figures.suspect_figure(content.events, names, content.loop),
        "budget": score_figures.budget_figure(content.ladder, content.loop.comparisons),
        "effects": None if diagnosis is None else score_figures.effects_figure(diagnosis),
        "offsets": model_figures.offsets_figure(content.model.parameters, names),
        "force": score_figures.force_figure(force) if force else None,
    }


def _sections(content: ReportContent) -> Iterator[tuple[int, PathView, list[Figure]]]:
    """Each path with its number, for links, and its figures."""
    for number, view in enumerate(content.paths, start=1):
        drawn = (
            path_figure(*(number, view, content.loop, content.events), drag=content.speed_limited),
            map_figure(number, view),
        )
        yield number, view, [f for f in drawn if f is not None]


def _tables(content: ReportContent, names: dict[str, str]) -> dict[str, tables.Table | None]:
    """The tables of the annex; None where there is nothing to show."""
    comparison, diagnosis = content.comparison, content.diagnosis
    rows = content.rows
    zones = [view.zones for view in content.paths if view.zones is not None]
    baseline = [row for view in content.paths for row in view.alpha_beta]
    found = {
        "design": tables.design_table(rows, names) if rows else None,
        "volume": tables.volume_runout_table(rows, names) if rows else None,
        "apart": tables.apart_table(rows, names),
        "volumes": tables.period_volumes_table(rows, names),
        "points": tables.points_table(rows, names),
        "zones": tables.zones_table(zones, names),
        "alpha_beta": tables.alpha_beta_table(baseline, names),
        "paths": tables.paths_table(content.summaries, names) if content.paths else None,
        "models": model_tables.ladder_table(content.ladder),
        "parameters": model_tables.parameters_table(content.model, offsets=False),
        "kinds": model_tables.kinds_table(content.model),
        "made": made_table(content),
    }
    if comparison is not None:
        parts = model_tables.compared_parts(comparison)
        found["scores"] = model_tables.scores_table(comparison.coordinate, parts)
        found["failures"] = model_tables.failures_table(comparison, names)
        found["budget"] = model_tables.budget_table(comparison)
        found["misfit"] = model_tables.misfit_table(comparison)
    if diagnosis is not None:
        found["candidates"] = model_tables.candidates_table(diagnosis)
        found["shape"] = model_tables.shape_table(diagnosis)
        found["laws"] = model_tables.laws_table(diagnosis)
        found["measure"] = model_tables.measure_table(diagnosis)
    return defaultdict(lambda: None, found)


def made_table(content: ReportContent) -> tables.Table:
    """Seeds, versions and fingerprints."""
    model = content.model
    checks = content.model.diagnostics
    day, _, hour = content.created.partition("T")
    draws = ", ".join(integer(n) for n in sorted({row.n_draws for row in content.rows}))
    rows = [
        (say("calibrated (UTC)"), f"{spoken().date(day)} {hour.removesuffix('Z')}".rstrip()),
        (
            say("method"),
            say(
                "{method}, {n} chains of {draws} draws",
                method=model.method,
                n=model.chains,
                draws=integer(model.draws),
            ),
        ),
        (say("seed"), model.seed),
        (
            say("convergence"),
            say(
                "R-hat {rhat}, effective sample size at least {ess}, {share} accepted",
                rhat=say("infinite")
                if checks.rhat_max is None
                else spoken().number(f"{checks.rhat_max:.3f}"),
                ess=integer(checks.ess_min),
                share=share(checks.acceptance),
            ),
        ),
        (say("fingerprint of the records (SHA-256)"), model.data_fingerprint),
        (say("calibrated on the paths"), ", ".join(content.calibrated_paths) or None),
        (say("fingerprint of the effect file (SHA-256)"), content.effect_sha256),
        (
            say("diagnosis"),
            content.diagnosis
            and say(
                "{n} synthetic datasets, seed {seed}",
                n=content.diagnosis.n_worlds,
                seed=content.diagnosis.seed,
            ),
        ),
        (say("draws of the design runouts"), draws and say("{n} for each row", n=draws)),
        *((say("version of {name}", name=n), version) for n, version in content.versions.items()),
    ]
    columns = (("", itemgetter(0)), ("", itemgetter(1)))
    known = [row for row in rows if row[1] not in (None, "")]
    return tables.made("made", say("How to reproduce it"), columns, known)


def _plotly() -> str:
    """Plotly's own script; it holds nothing that would end the element that it stands in."""
    from plotly.offline import get_plotlyjs  # noqa: PLC0415 (slow)

    script = str(get_plotlyjs())
    assert "</script" not in script.lower()
    return script


def _hash(script: str) -> str:
    """What the page's content security policy lets run: this script, and no other."""
    digest = hashlib.sha256(script.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(digest).decode('ascii')}"
