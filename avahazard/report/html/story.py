"""The loop in words: where a model failed, what was found, what was added, what it brought."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.criticism.scoring.error_budget import UNEXPLAINED
from avahazard.criticism.scoring.held_out import error_fall
from avahazard.report.html.content import ReportContent
from avahazard.report.html.summary import failing
from avahazard.report.html.words import (
    amount,
    axis_words,
    chance,
    kept_back,
    level_words,
    likelier,
    metres,
)
from avahazard.report.language import ENGLISH, Language
from avahazard.results.amounts import RATIO, bare, unit_of
from avahazard.results.comparison import Comparison
from avahazard.results.diagnosis import Candidate, Diagnosis


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
    return [words, *(language.told(where) for where in found.where)]


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
