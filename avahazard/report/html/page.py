"""The page: figures, tables and words put into the template."""

import base64
import hashlib
import re
from collections.abc import Sequence
from dataclasses import replace
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from avahazard.criticism.scoring.change import before_and_after
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.laws import law
from avahazard.notes import Note, grouped, placed
from avahazard.report import model_tables, sentences, tables, words
from avahazard.report.html import brief, figure, model_figures, record_figures, score_figures
from avahazard.report.html.content import ReportContent
from avahazard.report.html.figure import script_json
from avahazard.report.html.map_figure import map_figure
from avahazard.report.html.path_figure import path_figure
from avahazard.report.language import plural, say, spoken

UNIT = re.compile(
    r"(?<=\d) (?=(?:m[²³]?|m/s|kPa|nats)(?!\w))|(?<=\d) ?(?=%)| (?=[:;?!»×])|(?<=×) |(?<=«) "
)
DATE = re.compile(r"\b(\d{4})-(\d\d)-(\d\d)\b")


def render(content: ReportContent) -> str:
    """The whole report as HTML that needs nothing else: no network, no other file.

    It is in the language that is spoken.
    """
    folder = files("avahazard.report.html") / "templates"
    period = brief.shown_period(content)
    cards, common = brief.path_cards(content)
    shown = [row for row in content.rows if row.return_period_years == period]
    values = {
        "content": content,
        "language": spoken(),
        "period": period,
        "shown": shown,
        "passed": brief.passed(content, shown),
        "cards": cards,
        "common": common,
        "errors": {
            state.key: {key: getattr(state, key) for key in ("held_out_m", "crps_m", "rmse_m")}
            for state in content.loop.models
        },
        "law": law(content.model.law),
        "method": METHODS[content.model.method],
        "versions": [(say("version of {name}", name=n), v) for n, v in content.versions.items()],
        "style": Markup((folder / "report.css").read_text(encoding="utf-8")),  # noqa: S704 (our own)
    }
    script = ""
    if not content.brief:
        from plotly.offline import get_plotlyjs  # noqa: PLC0415 (slow)

        script = f"{get_plotlyjs()}\n{(folder / 'report.js').read_text(encoding='utf-8')}"
        assert "</script" not in script.lower()  # it would end the element
    code = Markup(script)  # noqa: S704 (our own)
    template = _environment().get_template("report.html.j2")
    # The page's content security policy lets this script run, and no other.
    digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    return template.render(values, script=code, script_hash=f"sha256-{digest}")


def doubt_of(content: ReportContent) -> str:
    """That the model errs less than its parent is not certain; empty where it is, or has none."""
    *_, parent, name = ("", *content.loop.lineage)
    before, after = map(content.loop.comparisons.get, (parent, name))
    return sentences.doubt_text(before_and_after(before, after), parent) if before and after else ""


SAID = ("stale", "unconverged")
OF_CARDS = ("part_beyond", "all_beyond", "extrapolated")
"""Notes that the brief says in its conclusion, and in the cards of the paths."""


def notes_of(content: ReportContent, but: Sequence[str] = SAID) -> list[str]:
    """The notes on the rows of bounds and on the model, a line for all of one kind.

    All but those of the keys `but` on the model itself.
    """
    names, model = content.names, content.model.model
    where: dict[Note, dict[str, None]] = {}
    for row in content.rows:
        for note in row.notes:
            if note not in content.of_model:
                where.setdefault(note, {})[names.get(row.path_id, row.path_id)] = None
    notes = placed(where, len({row.path_id for row in content.rows}))
    shown = [
        note
        for note in (*notes, *content.of_model)
        if note.key not in but or note.values.get("model", model) != model
    ]
    return [spoken().alone(note) for note in grouped(shown)]


def design_notes(content: ReportContent) -> list[str]:
    """The notes on what the design runouts rest on."""
    rows = [row for row in content.rows if row.design]
    return notes_of(replace(content, rows=rows), (*SAID, *OF_CARDS))


def every_note(content: ReportContent) -> list[str]:
    """The same notes, each by itself."""
    notes = [
        note.about(content.names.get(row.path_id, row.path_id))
        for row in content.rows
        for note in row.notes
        if note not in content.of_model
    ]
    return [spoken().alone(note) for note in dict.fromkeys((*notes, *content.of_model))]


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
    environment.install_gettext_callables(say, plural)  # type: ignore[attr-defined]
    pictures = (figure, model_figures, record_figures, score_figures)
    texts = (brief, model_tables, sentences, tables, words)
    sayings = (design_notes, doubt_of, every_note, notes_of)
    functions = (before_and_after, map_figure, path_figure, script_json)
    for used in (*pictures, *texts, *sayings, *functions):
        environment.globals[used.__name__.rpartition(".")[2]] = used
    environment.filters["integer"] = words.integer
    return environment


def kept_together(value: Any) -> Any:
    """Text with numbers and units, and dates, each on one line; HTML as it is."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    return DATE.sub("\\1\u2011\\2\u2011\\3", UNIT.sub("\u00a0", value))
