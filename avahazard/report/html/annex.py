"""What the annex says in sentences: the story of the model, and its notes."""

from __future__ import annotations

from avahazard.notes import Note, grouped, placed
from avahazard.report.html.content import ReportContent
from avahazard.report.language import say, spoken
from avahazard.report.sentences import change_text, error_text, failure_text, verdict_text
from avahazard.report.words import amount


def chapters(content: ReportContent) -> list[tuple[str, list[str]]]:
    """The story of the model from its first ancestor: a heading and sentences for each of the line.

    Empty where nothing was ever compared.
    """
    from avahazard.criticism.scoring.held_out import error_fall  # noqa: PLC0415 (slow)

    loop = content.loop
    added = {row.model: row.added for row in content.ladder}
    found = []
    for k, name in enumerate(loop.lineage):
        compared, diagnosis = loop.comparisons.get(name), loop.diagnoses.get(name)
        if compared is None and diagnosis is None:
            continue
        parent = loop.lineage[k - 1] if k else None
        before = loop.comparisons.get(parent or "")
        words: list[str] = []
        if compared is not None and before is not None:
            was, now = (c.held_out.runout.crps_m for c in (before, compared))
            if compared.held_out.parent_crps_m is not None:
                was = compared.held_out.parent_crps_m
            fall = error_fall(before, compared)
            words.append(change_text(was, now, compared.coordinate, fall))
        elif compared is not None:
            words += error_text(compared)[:1]
        if compared is not None and not (diagnosis and diagnosis.where):
            words.append(failure_text(compared))
        if diagnosis is not None:
            words.append(verdict_text(diagnosis))
        budget = {} if compared is None else {part.source: part.rms_m for part in compared.budget}
        if compared is not None and name == loop.lineage[-1] and budget.get("unexplained"):
            words.append(
                say(
                    "Unexplained: {size} (rms), beyond errors of the records, scatter and "
                    "uncertain parameters.",
                    size=amount(budget["unexplained"], compared.coordinate, 0),
                )
            )
        heading = say("“{name}”", name=name)
        if parent is not None:
            more = spoken().effects(added.get(name, ()))
            heading = say("“{model}”: “{parent}” and {more}", model=name, parent=parent, more=more)
        found.append((heading, words))
    return found


def notes_of(content: ReportContent) -> list[str]:
    """The notes on the rows of bounds and on the model, a line for all of one kind."""
    names, model = content.names, content.model.model
    # The brief says these.
    said = (Note("stale", model=model), Note("unconverged", model=model))
    where: dict[Note, dict[str, None]] = {}
    for row in content.rows:
        for note in row.notes:
            if note not in (*said, *content.of_model):
                where.setdefault(note, {})[names.get(row.path_id, row.path_id)] = None
    notes = placed(where, len({row.path_id for row in content.rows}))
    notes += [note for note in content.of_model if note not in said]
    return [spoken().note(note) for note in grouped(notes)]


def every_note(content: ReportContent) -> list[str]:
    """The same notes, each by itself."""
    names = content.names
    notes = [
        note.about(names.get(row.path_id, row.path_id))
        for row in content.rows
        for note in row.notes
        if note not in content.of_model
    ]
    return [spoken().note(note) for note in dict.fromkeys((*notes, *content.of_model))]
