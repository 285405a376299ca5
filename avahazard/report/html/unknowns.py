"""The first page in words: what the report cannot tell, and what the records do not say."""

from __future__ import annotations

from collections.abc import Sequence

from avahazard.hazard.notes import stale_words, unconverged_words
from avahazard.report.html.content import Document, ReportContent
from avahazard.report.language import Language
from avahazard.report.verdict_words import verdict_words

FEW_EVENTS = 5


def cannot_tell(content: ReportContent) -> list[str]:
    """What this report must not be used for, or only with care: from the results themselves."""
    words: list[str] = []
    model, language = content.model, content.language
    say = language.say
    if not model.diagnostics.converged:
        words.append(
            say("The chains of the sampler have not converged: every number here is provisional.")
        )
    if content.records_changed:
        words.append(
            say(
                "The records have changed since the model was calibrated: calibrate it again. "
                "Figures of the records show them as they are now."
            )
        )
    words += _of_bounds(content)
    if content.comparison is None:
        words.append(
            say("How far the model errs is not known: it was never set against the records.")
        )
    if content.diagnosis is None:
        words.append(
            say("Whether an effect is missing is not known: the model was never diagnosed.")
        )
    elif content.diagnosis.verdict != "adequate" or content.diagnosis.cannot_tell:
        words.append(verdict_words(content.diagnosis, language=language))
    bare = [v.name for v in content.paths if len(v.events) < FEW_EVENTS]
    if bare and len(bare) < len(content.paths):
        words.append(
            language.plural(
                "{paths} has fewer than {few} records: the bounds there stand on the other paths.",
                "{paths} have fewer than {few} records: the bounds there stand on the other paths.",
                len(bare),
                paths=_named(bare, language),
                few=FEW_EVENTS,
            )
        )
    return words


def _of_bounds(content: ReportContent) -> list[str]:
    names = {view.path.path_id: view.name for view in content.paths}
    language = content.language

    def where(rows: Sequence[Document]) -> str:
        found = [names.get(i, i) for i in dict.fromkeys(r["path_id"] for r in rows)]
        return _named(found, language)

    # What the summary says of the model as it is now goes without saying twice.
    known = (stale_words(content.model.model), unconverged_words(content.model.model))
    noted: dict[str, list[Document]] = {}
    for row in content.rows:
        for note in row.get("notes", ()):
            if note not in known:
                noted.setdefault(note, []).append(row)
    words = [f"{where(rows)}: {language.told(note)}" for note, rows in noted.items()]
    pooled = [row for row in content.rows if row.get("pooled")]
    if pooled:
        words.append(
            language.say(
                "{paths}: too few yearly volumes of its own; the spread of volumes is that of all "
                "paths together.",
                paths=where(pooled),
            )
        )
    return words


def _named(names: Sequence[str], language: Language) -> str:
    """Names in a row, the first few of many."""
    if len(names) > 8:
        return language.say("{names} and {n} more", names=", ".join(names[:7]), n=len(names) - 7)
    return ", ".join(names)


def unknown_words(content: ReportContent) -> list[str]:
    """What the records do not say, by count."""
    events, say, plural = content.events, content.language.say, content.language.plural
    total = len(events)
    no_volume = sum(e.volume_m3 is None for e in events)
    no_date = sum(e.year is None for e in events)
    left = sum(e.left_profile for e in events)
    no_path = sum(e.path_id is None for e in events)
    words = []
    if no_volume:
        words.append(
            plural(
                "{n} of {total} events has no volume.",
                "{n} of {total} events have no volume.",
                no_volume,
                total=total,
            )
        )
    if no_date:
        words.append(
            plural(
                "{n} of {total} events has no date.",
                "{n} of {total} events have no date.",
                no_date,
                total=total,
            )
        )
    if left:
        words.append(
            plural(
                "{n} of {total} events left its profile, so that only a least runout is known.",
                "{n} of {total} events left their profile, so that only a least runout is known.",
                left,
                total=total,
            )
        )
    if no_path:
        words.append(
            plural(
                "{n} of {total} events has no path, and so no profile: it is judged by height over "
                "length.",
                "{n} of {total} events have no path, and so no profile: they are judged by height "
                "over length.",
                no_path,
                total=total,
            )
        )
    if not content.n_speeds:
        words.append(
            say("No speeds were measured: what the speed does to friction cannot be seen.")
        )
    for name, n in content.covariates.items():
        if n:
            words.append(
                say("“{name}” is not known for {n} of {total} events.", name=name, n=n, total=total)
            )
    return words
