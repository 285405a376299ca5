"""The page: figures, tables and words put into the template."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from avahazard.report.html import effect_tables, model_tables, path_tables
from avahazard.report.html.baseline_words import baseline_words
from avahazard.report.html.bounds_table import bounds_table
from avahazard.report.html.budget_figure import budget_figure
from avahazard.report.html.content import PathView, ReportContent
from avahazard.report.html.density_figure import density_figure
from avahazard.report.html.effects_figure import effects_figure
from avahazard.report.html.figure import Figure
from avahazard.report.html.force_figure import force_figure
from avahazard.report.html.friction_figure import friction_figure
from avahazard.report.html.front import path_answers, shown_period
from avahazard.report.html.ladder_figure import ladder_figure
from avahazard.report.html.limits import assumptions, zone_words
from avahazard.report.html.made_table import made_table
from avahazard.report.html.map_figure import map_figure
from avahazard.report.html.path_figure import path_figure
from avahazard.report.html.posterior_figure import offsets_figure, posterior_figures
from avahazard.report.html.predicted_figure import predicted_figures
from avahazard.report.html.reading_words import reading_words
from avahazard.report.html.record_figure import record_figure
from avahazard.report.html.residuals_figure import residuals_figure
from avahazard.report.html.story import chapters
from avahazard.report.html.summary import failing, model_words, sure_words, why_words
from avahazard.report.html.switch import switch_json
from avahazard.report.html.table import HtmlTable
from avahazard.report.html.unknowns import cannot_tell, unknown_words
from avahazard.report.html.words import events, paths
from avahazard.report.language import Language
from avahazard.report.verdict_words import verdict_words


@dataclass(frozen=True, slots=True)
class PathSection:
    """One path in the page: its number for links, its figures and its remarks."""

    number: int
    view: PathView
    figures: tuple[Figure, ...]


def render(content: ReportContent) -> str:
    """The whole report as HTML that needs nothing else: no network, no other file."""
    folder = files("avahazard.report.html") / "templates"
    script = _plotly() + "\n" + (folder / "report.js").read_text(encoding="utf-8")
    model, comparison, diagnosis = content.model, content.comparison, content.diagnosis
    language, loop = content.language, content.loop
    names = {view.path.path_id: view.name for view in content.paths if view.events}
    answers = path_answers(content)
    return (
        _environment(language)
        .get_template("report.html.j2")
        .render(
            content=content,
            style=Markup((folder / "report.css").read_text(encoding="utf-8")),  # noqa: S704 (our own)
            script=Markup(script),  # noqa: S704 (our own)
            script_hash=_hash(script),
            model_words=model_words(content),
            why_words=why_words(content),
            sure_words=sure_words(content),
            cannot_tell=cannot_tell(content),
            unknown_words=unknown_words(content),
            assumptions=assumptions(content),
            zone_words=zone_words(content),
            verdict=None if diagnosis is None else verdict_words(diagnosis, language=language),
            by_words=_by_words(content),
            baseline_words=baseline_words(content),
            fails=comparison is not None and bool(failing(comparison)),
            figures=_figures(content, names),
            posterior=posterior_figures(model.parameters, content.draws, language),
            predicted=predicted_figures(content.events, names, loop, language),
            reading_words=reading_words(content.paths, stops=bool(loop.models), language=language),
            chapters=chapters(content),
            answers=answers,
            more_answers=language.plural("{n} more path", "{n} more paths", len(answers) - 12),
            period=shown_period(content),
            switch=switch_json(content),
            sections=list(_sections(content)),
            tables=_tables(content, names),
        )
    )


def _environment(language: Language) -> Environment:
    environment = Environment(
        loader=PackageLoader("avahazard.report.html", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        extensions=["jinja2.ext.i18n"],
    )
    # What the extension adds to an environment is not in its types.
    translations: Any = environment
    translations.install_gettext_callables(language.say, language.plural)
    return environment


def _by_words(content: ReportContent) -> str:
    """Under the title: which model, on how much."""
    language, model = content.language, content.model
    values = {
        "model": model.model,
        "date": language.date(content.created[:10]),
        "events": events(len(content.events), language),
    }
    if not content.paths:
        return language.say("Model “{model}”, calibrated {date} on {events}.", **values)
    return language.say(
        "Model “{model}”, calibrated {date} on {events}; {paths}.",
        paths=paths(len(content.paths), language),
        **values,
    )


def _figures(content: ReportContent, names: dict[str, str]) -> dict[str, Figure | None]:
    """The figures that stand by their names; None where there is nothing to draw."""
    comparison, diagnosis, language = content.comparison, content.diagnosis, content.language
    friction = content.friction
    force = () if comparison is None else comparison.measured_force
    return {
        "record": record_figure(content.events, content.paths, language),
        "ladder": ladder_figure(content),
        "friction": None
        if friction is None
        else friction_figure(friction, content.events, names, language),
        "density": density_figure(content.densities, names, language),
        "residuals": residuals_figure(content.events, names, content.loop, language),
        "budget": budget_figure(content),
        "effects": None if diagnosis is None else effects_figure(diagnosis, language),
        "offsets": offsets_figure(content.model.parameters, names, language),
        "force": force_figure(force, language) if force else None,
    }


def _sections(content: ReportContent) -> Iterator[PathSection]:
    for number, view in enumerate(content.paths, start=1):
        language = content.language
        drawn = (
            path_figure(number, view, content.loop, content.events, language),
            map_figure(number, view, language),
        )
        yield PathSection(number, view, tuple(f for f in drawn if f is not None))


def _tables(content: ReportContent, names: dict[str, str]) -> dict[str, HtmlTable | None]:
    comparison, diagnosis = content.comparison, content.diagnosis
    language = content.language
    return {
        "lines": path_tables.lines_table(content),
        "of_volume": path_tables.of_volume_table(content),
        "bounds": bounds_table(content),
        "paths": path_tables.paths_table(content.paths, language) if content.paths else None,
        "models": model_tables.ladder_table(content),
        "parameters": model_tables.parameters_table(content.model, language),
        "scores": None if comparison is None else model_tables.scores_table(comparison, language),
        "failures": None
        if comparison is None
        else model_tables.failures_table(comparison, names, language),
        "candidates": None
        if diagnosis is None
        else effect_tables.candidates_table(diagnosis, language),
        "measure": None if diagnosis is None else effect_tables.measure_table(diagnosis, language),
        "alpha_beta": path_tables.alpha_beta_table(content.paths, language),
        "zones": path_tables.zones_table(content.paths, language),
        "made": made_table(content),
    }


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
