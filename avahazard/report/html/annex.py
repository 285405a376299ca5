"""What the annex says in sentences: the story of the model, notes, assumptions, how to read."""

from __future__ import annotations

from avahazard.inference.model.choices import METHODS
from avahazard.notes import Note, grouped, placed
from avahazard.report.html.content import ReportContent
from avahazard.report.language import plural, say, spoken
from avahazard.report.sentences import change_text, error_text, failure_text, verdict_text
from avahazard.report.words import amount, some


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
            more = spoken().listed([spoken().effect(key) for key in added.get(name, ())])
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


def unknown_text(content: ReportContent) -> list[str]:
    """What the records do not say, by count."""
    events = content.events
    total = len(events)
    counts = {
        "volume": sum(e.volume_m3 is None for e in events),
        "date": sum(e.year is None for e in events),
        "left": sum(e.left_profile for e in events),
        "path": sum(e.path_id is None for e in events),
    }
    words = [
        plural("{n} of {total} events has no volume.", "{n} of {total} events have no volume.",
               counts["volume"], total=total),
        plural("{n} of {total} events has no date.", "{n} of {total} events have no date.",
               counts["date"], total=total),
        plural("{n} of {total} events ran beyond its profile: only a least runout is known.",
               "{n} of {total} events ran beyond their profile: only a least runout is known.",
               counts["left"], total=total),
        plural("{n} of {total} events has no path, and so no profile: it is judged by H/L.",
               "{n} of {total} events have no path, and so no profile: they are judged by H/L.",
               counts["path"], total=total),
    ]  # fmt: skip
    return some(
        *(n and text for text, n in zip(words, counts.values(), strict=True)),
        not content.n_speeds
        and say("No speeds were measured: how friction depends on speed cannot be determined."),
        *(
            n
            and say("“{name}” is not known for {n} of {total} events.", name=name, n=n, total=total)
            for name, n in content.covariates.items()
        ),
    )


def assumptions(content: ReportContent) -> list[str]:
    """Assumptions of the model, its data and its bounds, beside the limits of every report."""
    speeds = any(view.speeds or view.zones for view in content.paths)
    return some(
        say("Recorded volumes and runouts are taken with the errors that the records state."),
        say("The path is the smoothed profile."),
        METHODS[content.model.method].in_metres
        and say(
            "This model's scatter is in metres of elevation and holds all errors at once: "
            "natural variability, errors of the records and of the model."
        ),
        speeds and not content.speed_limited and no_drag_text(),
        any(view.alpha_beta for view in content.paths)
        and say(
            "The α-β runouts are regressions on extreme avalanches of other regions and do not "
            "use the records of these paths. Where records are many, the design runout carries "
            "more weight; where they are few, consider both."
        ),
    )


def no_drag_text() -> str:
    """The caveat of every picture of speed by a model without drag."""
    return say(
        "The model has no drag: nothing but friction limits its speeds, so that they and the "
        "pressures are too high where a path is steep and long."
    )


def reading_text(content: ReportContent) -> list[str]:
    """How to read the figures of the paths: of what they hold, once for all."""
    views = content.paths
    rows = [row for view in views for row in view.rows]
    zones, speeds = any(view.zones for view in views), any(view.speeds for view in views)
    return some(
        any(row.design for row in rows)
        and say(
            "Thick bars above the ground: 90 % credible interval of the design runout; the "
            "tick is its median."
        ),
        rows
        and say(
            "Thin lines: 90 % of avalanches of one volume, with their distribution. A bar that "
            "ends at the edge goes on beyond the profile."
        ),
        content.loop.models
        and say(
            "Under the profile every record has a line: the tick is where it stopped, the bar "
            "holds 90 % of where the model shown expects it, the grey one that of its parent."
        ),
        any(view.alpha_beta for view in views)
        and say("Stars: α-β runout with one standard deviation."),
        zones
        and say(
            "The strip at the foot shows the zones. Speeds are those that a year exceeds with "
            "chance 1/T: the median full, 95 % dashed, 5 % dotted; hover for the pressure."
        ),
        speeds
        and not zones
        and say("Speeds are those of the block of median friction at that volume."),
        (zones or speeds) and not content.speed_limited and no_drag_text(),
        any(row.reach for row in rows)
        and say(
            "The lowest panel: the annual probability that an avalanche reaches the place, with "
            "its 90 % credible interval."
        ),
    )
