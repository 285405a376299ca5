"""The loop in words: where a model failed, what was found, what was added, what it brought."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.criticism.scoring.budget_rows import UNEXPLAINED
from avahazard.criticism.scoring.error_fall import error_fall
from avahazard.report.html.content import ReportContent
from avahazard.report.html.summary import failing
from avahazard.report.html.words import axis_words, chance, count, likelier, metres
from avahazard.results.amounts import RATIO, amount, bare, unit_of
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
    loop = content.loop
    added = {row.model: row.added for row in content.ladder}
    told = []
    for k, name in enumerate(loop.lineage):
        if name not in loop.comparisons and name not in loop.diagnoses:
            continue
        parent = loop.lineage[k - 1] if k else None
        found = loop.comparisons.get(name)
        sentences: list[str] = []
        if found is not None:
            sentences += _error(found, loop.comparisons.get(parent or ""), parent)
            sentences += _failure(found)
        if name in loop.diagnoses:
            sentences += diagnosis_sentences(loop.diagnoses[name])
        if name == loop.lineage[-1]:
            sentences += _left(found, loop.diagnoses.get(name))
        more = ", ".join(added.get(name, ()))
        heading = f"“{name}”" if parent is None else f"“{name}”: “{parent}” and {more or 'no more'}"
        told.append(Chapter(name, heading, tuple(sentences)))
    return told


def _error(found: Comparison, before: Comparison | None, parent: str | None) -> list[str]:
    own = found.held_out.runout.crps_m
    what = "paths" if found.held_out.by == "path" else "events"
    if before is None:
        return [f"Its error on {what} kept back: {amount(own, found.coordinate)}."]
    was = before.held_out.runout.crps_m
    now, then = amount(own, found.coordinate), amount(was, found.coordinate)
    words = f"Its error on {what} kept back: {now}, after {then} of “{parent}”"
    fall = error_fall(before, found)
    if fall is None:
        return [f"{words}; too few groups were kept back to say how sure that is."]
    if fall.q05_m > 0.0:
        sure = "it fell"
    elif fall.q95_m < 0.0:
        sure = "it rose"
    else:
        sure = "whether it fell is not sure"
    low, high, mean = (
        _minus(bare(value, found.coordinate)) for value in (fall.q05_m, fall.q95_m, fall.mean_m)
    )
    unit = unit_of(found.coordinate)
    return [f"{words}: a fall of {mean} {unit} (90 %: {low} to {high} {unit}), so {sure}."]


def _failure(found: Comparison) -> list[str]:
    rows = failing(found)
    if not rows:
        return ["It fails nowhere that chance could not explain."]
    parts = [
        f"{axis_words(row.axis)} “{row.level}” ({count(row.n, 'event')}, "
        f"{_plus(row.bias_m, found.coordinate)})"
        for row in rows[:3]
    ]
    more = f", and {len(rows) - 3} more" if len(rows) > 3 else ""
    return [f"It fails beyond chance by {'; '.join(parts)}{more} (predicted less recorded)."]


def diagnosis_sentences(found: Diagnosis) -> list[str]:
    """What was asked of the model, what was found, and on which evidence."""
    asked = f"Asked for {count(len(found.candidates), 'effect')} that it might lack"
    candidates = {c.effect: c for c in found.candidates}
    if found.verdict == "adequate":
        return [
            f"{asked}, the records show none: one that moves runouts by "
            f"{_size(found.detectable_m, found.coordinate)} would have been seen 4 times in 5."
        ]
    named = [candidates[key] for key in found.missing if key in candidates]
    if found.verdict == "missing-effect" and named:
        words = [f"{asked}, the records name {named[0].effect}: {_evidence(named[0], found)}."]
    elif found.verdict == "ambiguous" and named:
        each = "; ".join(f"{c.effect} ({_evidence(c, found)})" for c in named)
        words = [f"{asked}, the records name several that they cannot tell apart: {each}."]
    else:
        words = [
            f"{asked}, none explains what is seen along {', '.join(found.missing)}: it is there, "
            "and no physics of the catalogue has its shape."
        ]
    return [*words, *found.where]


def _evidence(candidate: Candidate, found: Diagnosis) -> str:
    """The gain in plain words: how much likelier the records are, and how often chance does it."""
    floor = 1.0 / (found.n_worlds + 1)
    seldom = (
        f"in none of {found.n_worlds} made worlds that lack nothing did chance do as much"
        if candidate.p_value <= floor * 1.0001
        else f"chance does as much in {candidate.p_value:.0%} of made worlds that lack nothing"
    )
    p = chance(candidate.p_value, floor)
    sign = "" if p.startswith("<") else "= "
    return (
        f"with it the records are {likelier(candidate.screened_gain)} likelier than without, and "
        f"{seldom} (p {sign}{p})"
    )


def _left(found: Comparison | None, diagnosis: Diagnosis | None) -> list[str]:
    """What is still not explained."""
    words = []
    budget = {} if found is None else {part.source: part.rms_m for part in found.budget}
    if found is not None and UNEXPLAINED in budget:
        size = _size(budget[UNEXPLAINED], found.coordinate)
        words.append(
            f"Still unexplained: {size} (root mean square), beyond what "
            "errors of the records, natural scatter and parameters let expect."
            if budget[UNEXPLAINED] > 0.0
            else "Nothing is left that errors of the records, natural scatter and parameters do "
            "not let expect."
        )
    if diagnosis is None:
        words.append("Whether it still lacks an effect was not asked.")
    return words


def _minus(text: str) -> str:
    return text.replace("-", "−")


def _size(value: float, coordinate: str) -> str:
    return amount(value, coordinate) if coordinate == RATIO else metres(value)


def _plus(value: float, coordinate: str) -> str:
    sign = "-" if value < 0.0 else "+"
    return _minus(sign + amount(abs(value), coordinate, 0))
