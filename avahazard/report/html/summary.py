"""The first page in words: which model, how sure it is, and what it cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from avahazard.hazard.notes import stale_words, unconverged_words
from avahazard.inference.model.laws import law
from avahazard.report.html.content import Document, ReportContent
from avahazard.report.html.words import COORDINATES, axis_words, count, number, share
from avahazard.report.verdict_words import verdict_words
from avahazard.results.amounts import amount
from avahazard.results.comparison import Comparison, Failure

METHODS = {
    "marginal": "the marginal likelihood, which knows the errors of the records",
    "gibbs": "the Gibbs sampler of Ancey (2005)",
    "metropolis": "the Metropolis-Hastings sampler of Ancey (2005)",
}
SIGNIFICANT = 0.05
FEW_EVENTS = 5


def model_words(content: ReportContent) -> list[str]:
    """What the model is, in two or three sentences."""
    model = content.model
    n_paths = len({e.path_id for e in content.events if e.path_id is not None})
    where = f" on {count(n_paths, 'path')}" if n_paths else ", without profiles"
    words = [
        f"The avalanche is a block that slides down the path; its friction μ "
        f"{law(model.law).words}. The model was calibrated on "
        f"{count(model.n_events, 'event')}{where}, by {METHODS[model.method]}."
    ]
    if model.method == "metropolis":
        words.append("Stops scatter about that of the block by σ metres of elevation.")
    else:
        tails = ", with heavy tails (Student's t)" if model.tails == "student" else ""
        words.append(
            f"From one avalanche to the next friction scatters ({model.distribution}{tails})"
            + (", less or more by volume." if model.scatter == "volume" else ".")
        )
    if model.effects:
        words.append(f"It has these effects besides: {', '.join(model.effects)}.")
    if not model.centrifugal:
        words.append("The load of the path's curvature on the bed is left out.")
    if model.parent:
        words.append(f"It was made from the model “{model.parent}”.")
    return words


def why_words(content: ReportContent) -> list[str]:
    """Why this model and not another of the ladder: its error on what it had not seen."""
    known = {
        row.model: row.held_out_crps_m for row in content.ladder if row.held_out_crps_m is not None
    }
    name = content.model.model
    if len(known) < 2 or name not in known:
        return []
    best = min(known, key=lambda key: known[key])
    coordinate = next(row.coordinate for row in content.ladder if row.model == name)
    own, least = amount(known[name], coordinate), amount(known[best], coordinate)
    if best == name:
        words = [
            f"Of {len(known)} compared models it has the least error, the CRPS on records kept "
            f"back: {own}."
        ]
    else:
        words = [
            f"Of {len(known)} compared models “{best}” has the least error, the CRPS on records "
            f"kept back: {least}; this one has {own}."
        ]
    parent = content.model.parent
    if parent in known and parent != best:
        words.append(f"Its parent “{parent}” has {amount(known[parent], coordinate)}.")
    return words


def sure_words(content: ReportContent) -> list[str]:
    """How far the model misses records that it had not seen; empty where it was not compared."""
    if content.comparison is None:
        return []
    held = content.comparison.held_out
    runout = held.runout
    what = "paths" if held.by == "path" else "events"
    of = COORDINATES[content.comparison.coordinate]
    crps, rmse, floor = (
        amount(value, content.comparison.coordinate, digits)
        for value, digits in (
            (runout.crps_m, 1),
            (runout.rmse_m, 0),
            (runout.noise_floor_m, 0),
        )
    )
    along = ""
    if held.runout_x is not None and content.comparison.coordinate != "x":
        along = f" and {number(held.runout_x.crps_m)} m of distance along the path"
    words = [
        f"The error of the model, on {what} that were kept back: {crps} of {of}"
        f"{along} (CRPS; of a forecast without scatter it would be the mean absolute error).",
        f"Root mean square of predicted mean less record: {rmse} of {of}. Errors "
        f"of the recorded runouts and volumes alone would leave {floor}; "
        "what varies from avalanche to avalanche comes on top for every model.",
        f"{share(runout.coverage_90)} of these records lie in the interval that should hold 90 %.",
    ]
    if held.speed is not None:
        words.append(
            f"Measured speeds are missed by {held.speed.rmse_m_s:.1f} m/s (root mean square)."
        )
    fails = failing(content.comparison)
    if fails:
        worst = fails[0]
        words.append(
            f"It fails where chance cannot explain it: first by {axis_words(worst.axis)}, "
            f"“{worst.level}” ({count(len(fails), 'level')} in all)."
        )
    else:
        words.append("It fails nowhere that chance could not explain.")
    return words


def failing(comparison: Comparison) -> list[Failure]:
    """Levels where the model fails beyond chance."""
    return [row for row in comparison.where_it_fails if row.p_value < SIGNIFICANT]


def cannot_tell(content: ReportContent) -> list[str]:
    """What this report must not be used for, or only with care: from the results themselves."""
    words: list[str] = []
    model = content.model
    if not model.diagnostics.converged:
        words.append(
            "The chains of the sampler have not converged: every number here is provisional."
        )
    if content.records_changed:
        words.append(
            "The records have changed since the model was calibrated: calibrate it again. Figures "
            "of the records show them as they are now."
        )
    words += _of_bounds(content)
    if content.comparison is None:
        words.append("How far the model errs is not known: it was never set against the records.")
    if content.diagnosis is None:
        words.append("Whether an effect is missing is not known: the model was never diagnosed.")
    elif content.diagnosis.verdict != "adequate":
        words.append(verdict_words(content.diagnosis))
    bare = [v.name for v in content.paths if len(v.events) < FEW_EVENTS]
    if bare and len(bare) < len(content.paths):
        words.append(
            f"{_named(bare)} {'has' if len(bare) == 1 else 'have'} fewer than {FEW_EVENTS} "
            "records: the bounds there stand on the other paths."
        )
    return words


def _of_bounds(content: ReportContent) -> list[str]:
    names = {view.path.path_id: view.name for view in content.paths}

    def where(rows: Sequence[Document]) -> str:
        return _named([names.get(i, i) for i in dict.fromkeys(r["path_id"] for r in rows)])

    # What the summary says of the model as it is now goes without saying twice.
    known = (stale_words(content.model.model), unconverged_words(content.model.model))
    noted: dict[str, list[Document]] = {}
    for row in content.rows:
        for note in row.get("notes", ()):
            if note not in known:
                noted.setdefault(note, []).append(row)
    words = [f"{where(rows)}: {note}" for note, rows in noted.items()]
    pooled = [row for row in content.rows if row.get("pooled")]
    if pooled:
        words.append(
            f"{where(pooled)}: too few yearly volumes of its own; the spread of volumes is that of "
            "all paths together."
        )
    return words


def _named(names: Sequence[str]) -> str:
    """Names in a row, the first few of many."""
    if len(names) > 8:
        return f"{', '.join(names[:7])} and {len(names) - 7} more"
    return ", ".join(names)


def unknown_words(content: ReportContent) -> list[str]:
    """What the records do not say, by count."""
    events = content.events
    lacking: dict[str, Any] = {
        "have no volume": sum(e.volume_m3 is None for e in events),
        "have no date": sum(e.year is None for e in events),
        "left their profile, so that only a least runout is known": sum(
            e.left_profile for e in events
        ),
        "have no path, and so no profile: they are judged by height over length": sum(
            e.path_id is None for e in events
        ),
    }
    words = [f"{n} of {len(events)} events {what}." for what, n in lacking.items() if n]
    if not content.n_speeds:
        words.append("No speeds were measured: what the speed does to friction cannot be seen.")
    for name, n in content.covariates.items():
        if n:
            words.append(f"“{name}” is not known for {n} of {len(events)} events.")
    return words
