"""What the annex says of a step of the model, and the notes."""

from __future__ import annotations

from avahazard.notes import Note, grouped, placed
from avahazard.report.html.content import ReportContent
from avahazard.report.language import spoken
from avahazard.report.sentences import change_text
from avahazard.results.comparison import Comparison


def fall_text(before: Comparison, after: Comparison) -> str:
    """How the held-out error changes from a model to its child."""
    from avahazard.criticism.scoring.held_out import error_fall  # noqa: PLC0415 (slow)

    was, now = after.held_out.parent_crps_m, after.held_out.runout.crps_m
    if was is None:
        was = before.held_out.runout.crps_m
    return change_text(was, now, after.coordinate, error_fall(before, after))


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
