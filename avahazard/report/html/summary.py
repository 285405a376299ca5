"""The first page in words: which model, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.criticism.scoring.error_budget import UNEXPLAINED
from avahazard.criticism.scoring.held_out import error_fall
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.laws import law
from avahazard.report.html.content import ReportContent
from avahazard.report.html.words import (
    amount,
    axis_words,
    chance,
    events,
    kept_back,
    level_words,
    likelier,
    metres,
    number,
    of_coordinate,
    paths,
    share,
)
from avahazard.report.language import ENGLISH, Language
from avahazard.results.base import RATIO, bare, unit_of
from avahazard.results.comparison import Comparison, Failure
from avahazard.results.diagnosis import Candidate, Diagnosis

SIGNIFICANT = 0.05


def model_words(content: ReportContent) -> list[str]:
    """What the model is, in two or three sentences."""
    model, language = content.model, content.language
    say = language.say
    n_paths = len({e.path_id for e in content.events if e.path_id is not None})
    words = [
        say(
            "The avalanche is a block that slides down the path; its friction μ {law}.",
            law=say(law(model.law).words),
        ),
        say(
            "The model was calibrated on {events} on {paths}, by {method}.",
            events=events(model.n_events, language),
            paths=paths(n_paths, language),
            method=say(METHODS[model.method].words),
        )
        if n_paths
        else say(
            "The model was calibrated on {events}, without profiles, by {method}.",
            events=events(model.n_events, language),
            method=say(METHODS[model.method].words),
        ),
    ]
    if METHODS[model.method].in_metres:
        words.append(say("Stops scatter about that of the block by σ metres of elevation."))
    else:
        families = {"lognormal": say("lognormal"), "normal": say("normal")}
        family = families[model.distribution]
        if model.tails == "student":
            family += say(", with heavy tails (Student's t)")
        words.append(
            say(
                "From one avalanche to the next friction scatters ({family}), less or more by "
                "volume.",
                family=family,
            )
            if model.scatter == "volume"
            else say("From one avalanche to the next friction scatters ({family}).", family=family)
        )
    if model.effects:
        named = ", ".join(language.effect(key) for key in model.effects)
        words.append(say("It has these effects besides: {effects}.", effects=named))
    if not model.centrifugal:
        words.append(say("The load of the path's curvature on the bed is left out."))
    if model.parent:
        words.append(say("It was made from the model “{model}”.", model=model.parent))
    return words


def why_words(content: ReportContent) -> list[str]:
    """Why this model and not another of the ladder: its error on what it had not seen."""
    say = content.language.say
    known = {
        row.model: row.held_out_crps_m for row in content.ladder if row.held_out_crps_m is not None
    }
    name = content.model.model
    if len(known) < 2 or name not in known:
        return []
    best = min(known, key=lambda key: known[key])
    coordinate = next(row.coordinate for row in content.ladder if row.model == name)
    own, least = (amount(known[key], coordinate, language=content.language) for key in (name, best))
    if best == name:
        words = [
            say(
                "Of {n} compared models it has the least error, the CRPS on records kept back: "
                "{error}.",
                n=len(known),
                error=own,
            )
        ]
    else:
        words = [
            say(
                "Of {n} compared models “{best}” has the least error, the CRPS on records kept "
                "back: {least}; this one has {error}.",
                n=len(known),
                best=best,
                least=least,
                error=own,
            )
        ]
    parent = content.model.parent
    if parent in known and parent != best:
        error = amount(known[parent], coordinate, language=content.language)
        words.append(say("Its parent “{parent}” has {error}.", parent=parent, error=error))
    return words


def sure_words(content: ReportContent) -> list[str]:
    """How far the model misses records that it had not seen; empty where it was not compared."""
    if content.comparison is None:
        return []
    language, held = content.language, content.comparison.held_out
    say, runout = language.say, held.runout
    coordinate = content.comparison.coordinate
    crps, rmse, floor = (
        amount(value, coordinate, digits, language)
        for value, digits in ((runout.crps_m, 1), (runout.rmse_m, 0), (runout.noise_floor_m, 0))
    )
    error = of_coordinate(crps, coordinate, language)
    if held.runout_x is not None and coordinate != "x":
        error = say(
            "{error} and {along} m of distance along the path",
            error=error,
            along=number(held.runout_x.crps_m, language),
        )
    words = [
        say(
            "The error of the model, {where}: {error} (CRPS; of a forecast without scatter it "
            "would be the mean absolute error).",
            where=kept_back(held.by, language),
            error=error,
        ),
        say(
            "Root mean square of predicted mean less record: {error}. Errors of the records "
            "alone (runout, volume, release) would leave {floor}; what varies from avalanche to "
            "avalanche comes on top for every model.",
            error=of_coordinate(rmse, coordinate, language),
            floor=floor,
        ),
        say(
            "{share} of these records lie in the interval that should hold 90 %.",
            share=share(runout.coverage_90, language),
        ),
    ]
    if held.speed is not None:
        words.append(
            say(
                "Measured speeds are missed by {error} m/s (root mean square).",
                error=language.number(f"{held.speed.rmse_m_s:.1f}"),
            )
        )
    fails = failing(content.comparison)
    if fails:
        words.append(
            language.plural(
                "It fails where chance cannot explain it: first by {axis}, “{level}” ({n} level "
                "in all).",
                "It fails where chance cannot explain it: first by {axis}, “{level}” ({n} levels "
                "in all).",
                len(fails),
                axis=axis_words(fails[0].axis, language),
                level=level_words(fails[0].level, language),
            )
        )
    else:
        words.append(say("It fails nowhere that chance could not explain."))
    return words


def failing(comparison: Comparison) -> list[Failure]:
    """Levels where the model fails beyond chance."""
    return [row for row in comparison.where_it_fails if row.p_value < SIGNIFICANT]


@dataclass(frozen=True, slots=True)
class Chapter:
    """One model of the line: its heading and its sentences."""

    model: str
    heading: str
    sentences: tuple[str, ...]


def chapters(content: ReportContent) -> list[Chapter]:
    """The story of the model from its first ancestor; empty where nothing was ever compared."""
    loop, language = content.loop, content.language
    added = {row.model: row.added for row in content.ladder}
    told = []
    for k, name in enumerate(loop.lineage):
        if name not in loop.comparisons and name not in loop.diagnoses:
            continue
        parent = loop.lineage[k - 1] if k else None
        found = loop.comparisons.get(name)
        sentences: list[str] = []
        if found is not None:
            sentences += _error(found, loop.comparisons.get(parent or ""), parent, language)
            sentences += _failure(found, language)
        if name in loop.diagnoses:
            sentences += diagnosis_sentences(loop.diagnoses[name], language)
        if name == loop.lineage[-1]:
            sentences += _left(found, loop.diagnoses.get(name), language)
        heading = language.say("“{name}”", name=name)
        if parent is not None:
            more = ", ".join(language.effect(key) for key in added.get(name, ()))
            heading = language.say(
                "“{model}”: “{parent}” and {more}",
                model=name,
                parent=parent,
                more=more or language.say("no more"),
            )
        told.append(Chapter(name, heading, tuple(sentences)))
    return told


def _error(
    found: Comparison, before: Comparison | None, parent: str | None, language: Language
) -> list[str]:
    say, where = language.say, kept_back(found.held_out.by, language)
    now = amount(found.held_out.runout.crps_m, found.coordinate, language=language)
    if before is None:
        return [say("Its error {where}: {error}.", where=where, error=now)]
    was = amount(before.held_out.runout.crps_m, found.coordinate, language=language)
    words = say(
        "Its error {where}: {error}, after {was} of “{parent}”",
        where=where,
        error=now,
        was=was,
        parent=parent,
    )
    fall = error_fall(before, found)
    if fall is None:
        return [say("{words}; too few groups were kept back to say how sure that is.", words=words)]
    if fall.q05_m > 0.0:
        sure = say("it fell")
    elif fall.q95_m < 0.0:
        sure = say("it rose")
    else:
        sure = say("whether it fell is not sure")
    low, high, mean = (
        language.number(bare(value, found.coordinate))
        for value in (fall.q05_m, fall.q95_m, fall.mean_m)
    )
    return [
        say(
            "{words}: a fall of {mean} {unit} (90 %: {low} to {high} {unit}), so {sure}.",
            words=words,
            mean=mean,
            low=low,
            high=high,
            unit=unit_of(found.coordinate),
            sure=sure,
        )
    ]


def _failure(found: Comparison, language: Language) -> list[str]:
    say, rows = language.say, failing(found)
    if not rows:
        return [say("It fails nowhere that chance could not explain.")]
    named = "; ".join(
        language.plural(
            "{axis} “{level}” ({n} event, {bias})",
            "{axis} “{level}” ({n} events, {bias})",
            row.n,
            axis=axis_words(row.axis, language),
            level=level_words(row.level, language),
            bias=_plus(row.bias_m, found.coordinate, language),
        )
        for row in rows[:3]
    )
    if len(rows) > 3:
        named = say("{names}, and {n} more", names=named, n=len(rows) - 3)
    return [say("It fails beyond chance by {names} (predicted less recorded).", names=named)]


def diagnosis_sentences(found: Diagnosis, language: Language = ENGLISH) -> list[str]:
    """What was asked of the model, what was found, and on which evidence."""
    say = language.say
    asked = language.plural(
        "Asked for {n} effect that it might lack",
        "Asked for {n} effects that it might lack",
        len(found.candidates),
    )
    candidates = {c.effect: c for c in found.candidates}
    if found.verdict == "adequate":
        size = _size(found.detectable_m, found.coordinate, language)
        if found.cannot_tell:
            return [
                say(
                    "{asked}, the records show none, but cannot tell: one behind half of the "
                    "scatter could have been missed. One that moves runouts by {size} would have "
                    "been seen 4 times in 5.",
                    asked=asked,
                    size=size,
                )
            ]
        return [
            say(
                "{asked}, the records show none: one that moves runouts by {size} would have been "
                "seen 4 times in 5.",
                asked=asked,
                size=size,
            )
        ]
    named = [candidates[key] for key in found.missing if key in candidates]
    if found.verdict == "missing-effect" and named:
        words = say(
            "{asked}, the records name {effect}: {evidence}.",
            asked=asked,
            effect=language.effect(named[0].effect),
            evidence=_evidence(named[0], found, language),
        )
    elif found.verdict == "ambiguous" and named:
        each = "; ".join(
            f"{language.effect(c.effect)} ({_evidence(c, found, language)})" for c in named
        )
        words = say(
            "{asked}, the records name several that they cannot tell apart: {effects}.",
            asked=asked,
            effects=each,
        )
    else:
        words = say(
            "{asked}, none explains what is seen along {missing}: it is there, and no physics of "
            "the catalogue has its shape.",
            asked=asked,
            missing=", ".join(language.effect(key) for key in found.missing),
        )
    return [words, *(language.note(where) for where in found.where)]


def _evidence(candidate: Candidate, found: Diagnosis, language: Language) -> str:
    """The gain in plain words: how much likelier the records are, and how often chance does it."""
    say, floor = language.say, 1.0 / (found.n_worlds + 1)
    seldom = (
        say(
            "in none of {n} made worlds that lack nothing did chance do as much",
            n=found.n_worlds,
        )
        if candidate.p_value <= floor * 1.0001
        else say(
            "chance does as much in {share} of made worlds that lack nothing",
            share=f"{candidate.p_value:.0%}".replace("%", " %"),
        )
    )
    p = chance(candidate.p_value, floor, language)
    return say(
        "with it the records are {times} likelier than without, and {seldom} (p {p})",
        times=likelier(candidate.screened_gain, language),
        seldom=seldom,
        p=p if p.startswith("<") else f"= {p}",
    )


def _left(found: Comparison | None, diagnosis: Diagnosis | None, language: Language) -> list[str]:
    """What is still not explained."""
    say = language.say
    words = []
    budget = {} if found is None else {part.source: part.rms_m for part in found.budget}
    if found is not None and UNEXPLAINED in budget:
        words.append(
            say(
                "Still unexplained: {size} (root mean square), beyond what errors of the records, "
                "natural scatter and parameters let expect.",
                size=_size(budget[UNEXPLAINED], found.coordinate, language),
            )
            if budget[UNEXPLAINED] > 0.0
            else say(
                "Nothing is left that errors of the records, natural scatter and parameters do "
                "not let expect."
            )
        )
    if diagnosis is None:
        words.append(say("Whether it still lacks an effect was not asked."))
    return words


def _size(value: float, coordinate: str, language: Language) -> str:
    if coordinate == RATIO:
        return amount(value, coordinate, language=language)
    return metres(value, language)


def _plus(value: float, coordinate: str, language: Language) -> str:
    return ("" if value < 0.0 else "+") + amount(value, coordinate, 0, language)
