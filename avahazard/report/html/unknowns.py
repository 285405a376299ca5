"""The first page in words: what the report cannot tell, and what the records do not say."""

from __future__ import annotations

from avahazard.inference.model.choices import METHODS
from avahazard.notes import Note, grouped, placed
from avahazard.report.html.content import Document, PathView, ReportContent
from avahazard.report.html.front import shown_period
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
                paths=language.few(bare),
                few=FEW_EVENTS,
            )
        )
    return words


def _of_bounds(content: ReportContent) -> list[str]:
    """The notes on single paths, then those on the model."""
    names = {view.path.path_id: view.name for view in content.paths}
    language, model = content.language, content.model.model

    def named(row: Document) -> str:
        return names.get(str(row["path_id"])) or str(row["path_id"])

    # What is said above needs no second sentence.
    said = (Note("stale", model=model), Note("unconverged", model=model))
    where: dict[Note, dict[str, None]] = {}
    for row in content.rows:
        for note in map(Note.read, row.get("notes", ())):
            if note not in (*said, *content.of_model):
                where.setdefault(note, {})[named(row)] = None
    notes = placed(where, len({row["path_id"] for row in content.rows}))
    notes += [note for note in content.of_model if note not in said]
    words = [language.note(note) for note in grouped(notes)]
    pooled = [named(row) for row in content.rows if row.get("pooled")]
    if pooled:
        words.append(
            language.say(
                "{paths}: too few yearly volumes of its own; the spread of volumes is that of all "
                "paths together.",
                paths=language.few(list(dict.fromkeys(pooled))),
            )
        )
    return words


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


def assumptions(content: ReportContent) -> list[str]:
    """Assumptions of the model, its data and its bounds, a sentence or two each."""
    model, language = content.model, content.language
    say = language.say
    words = [
        say(
            "The avalanche is one block on one line. It does not spread, branch or pile up, and a "
            "runout is a point on that line, not an outline on the map."
        ),
        say(
            "The path is the smoothed profile. What dams, new forest or other works change is not "
            "in it."
        ),
        say(
            "Recorded volumes and runouts are taken with the errors that the records state. An "
            "avalanche that nobody recorded is not in the model, unless a limit of sight was given."
        ),
    ]
    design = next((row["design"] for row in content.rows if row.get("design")), None)
    if design is not None:
        words.append(
            say(
                "The design runout of a return period mixes avalanches of all volumes, as often "
                "as they come. Its interval: {interval}.",
                interval=language.note(design["interval"]),
            )
        )
    if content.rows:
        each = dict.fromkeys(language.note(row["interval"]) for row in content.rows)
        words.append(
            say(
                "The runout of a volume lets friction vary. Its interval: {interval}.",
                interval="; ".join(each),
            )
        )
    if any(row["return_period_years"] is not None for row in content.rows):
        words.append(
            say(
                "The climate, the forest and the way of recording are taken to be the same in the "
                "future as in the observed years."
            )
        )
    if METHODS[model.method].in_metres:
        words.append(
            say(
                "This model's scatter is in metres of elevation and holds all errors at once: "
                "natural scatter, errors of the records and of the model."
            )
        )
    speeds = any(view.speeds or view.zones for view in content.paths)
    if speeds and not content.speed_limited:
        words.append(
            say(
                "The model has no drag: nothing but friction limits its speeds, so that they are "
                "too high where a path is steep and long, and so are pressures."
            )
        )
    if any(view.alpha_beta for view in content.paths):
        words.append(
            say(
                "The α-β runouts are regressions of other regions' extreme avalanches on the "
                "shape of the ground. They know nothing of the records here."
            )
        )
    words.append(
        say(
            "A report is no permit: a line on a map is for those who know the place, its history "
            "and its use."
        )
    )
    return words


def zone_words(content: ReportContent) -> list[str]:
    """What the zones and their pressures mean."""
    zones = [view.zones for view in content.paths if view.zones]
    if not zones:
        return []
    language, density = content.language, zones[0]["density_kg_m3"]
    return [
        language.say(
            "Zones by the limits “{limits}”. Pressure is ρu², with a density of {mean} ± {sd} "
            "kg/m³. Speeds and pressures: {interval}.",
            limits=language.say(zones[0]["limits"]),
            mean=f"{density['mean']:.0f}",
            sd=f"{density['sd']:.0f}",
            interval=language.note(zones[0]["interval"]),
        )
    ]


def baseline_words(content: ReportContent) -> list[str]:
    """On which paths α-β and the model disagree, and what that means; where it has no answer."""
    say = content.language.say
    period = shown_period(content)
    shorter: list[str] = []
    farther: list[str] = []
    for view in content.paths:
        design = _design(view, period)
        for row in view.alpha_beta if design is not None else ():
            side = _side(row, design or {})
            if side:
                named = f"{view.name} ({say(row['coefficients'])})"
                (shorter if side < 0 else farther).append(named)
    words = []
    if shorter:
        words.append(
            say(
                "Shorter than all that the design runout may be, 9 times in 10: {paths}.",
                paths=", ".join(shorter),
            )
        )
    if farther:
        words.append(
            say(
                "Farther than all that the design runout may be, 9 times in 10: {paths}.",
                paths=", ".join(farther),
            )
        )
    if shorter or farther:
        words.append(
            say(
                "There the records of the path say something else than its ground. α-β is the "
                "mean of extreme avalanches of another region on ground of that shape: where "
                "records are many, they weigh more; where they are few, look at both."
            )
        )
    without = [v.name for v in content.paths if any(r["beta_deg"] is None for r in v.alpha_beta)]
    if without:
        words.append(
            say(
                "No β-point: {paths}. The profile never flattens to 10°, where β is measured, so "
                "that α-β has no answer there.",
                paths=", ".join(without),
            )
        )
    return words


def _design(view: PathView, period: float | None) -> Document | None:
    rows = (r for r in view.rows if r.get("design") and r["return_period_years"] == period)
    return next((row["design"] for row in rows), None)


def _side(row: Document, design: Document) -> int:
    """−1 where α-β with one standard deviation lies short of the 90 %, 1 beyond it, else 0."""
    found, x = row["runout_x_m"], design["runout_x_m"]
    low, high = row["runout_x_low_m"], row["runout_x_high_m"]
    if found is None:
        return 0
    if high is not None and x["q05"] is not None and high < x["q05"]:
        return -1
    return 1 if low is not None and x["q95"] is not None and low > x["q95"] else 0
