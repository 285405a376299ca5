"""From the candidates that earned their names to the answer.

What else could explain the same is asked in turn: errors that are misstated or stops unseen, two
effects that count only together, groups that differ; last, what else is needed beside the answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avahazard.criticism.diagnosis.named_groups import named_group
from avahazard.criticism.diagnosis.naming import Naming
from avahazard.criticism.diagnosis.other_readings import read_otherwise
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.together import Together, masked_pair, needed_beside
from avahazard.criticism.diagnosis.verdict import verdict_of
from avahazard.criticism.screening.significance import Screening
from avahazard.effects.effect import Definition
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations


@dataclass(frozen=True, slots=True)
class Answer:
    """The verdict, the keys that it names, and effects that are needed together."""

    verdict: str
    missing: tuple[str, ...]
    together: tuple[Together, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """What every step asks of: the data, the user's own effects, the base, the full refits."""

    observations: Observations
    own: Sequence[Definition]
    base: Refit
    fits: Mapping[str, Refit]
    screening: Screening


def answer_of(question: Question, naming: Naming, granted: Sequence[str]) -> Answer:
    """The answer; `granted` are the nuisances that the base was given, by key."""
    answer = beside_other_readings(question, Answer(naming.verdict, naming.missing))
    rivals = tuple(question.fits.values()) if answer.missing else ()
    if not answer.missing:
        answer, rivals = or_a_masked_pair(question, answer)
    q = question
    group = named_group(q.observations, q.own, q.base, rivals, q.screening, granted)
    if group:
        return Answer(*verdict_of([find_definition(key, q.own) for key in group]))
    return with_what_is_needed_beside(question, answer)


def beside_other_readings(question: Question, answer: Answer) -> Answer:
    """A leader that stops unseen, or errors of volumes, explain as well is not told apart."""
    q = question
    missing = answer.missing
    if not missing or missing[0] not in q.fits:
        return answer
    others = read_otherwise(q.observations, q.own, q.base, q.fits, missing[0], q.screening)
    more = tuple(other for other in others if other not in missing)
    return Answer("ambiguous", (*missing, *more)) if more else answer


def or_a_masked_pair(question: Question, answer: Answer) -> tuple[Answer, tuple[Refit, ...]]:
    """Where nothing shows alone: two effects that hide each other, and their fit as a rival."""
    q = question
    pair = masked_pair(q.observations, q.own, q.base, q.screening)
    if pair is None:
        return answer, ()
    return Answer(*verdict_of_pair(pair, q.own), (pair,)), (pair.fit,)


def with_what_is_needed_beside(question: Question, answer: Answer) -> Answer:
    """The named effect with those that are needed beside it."""
    q = question
    if not answer.missing or answer.missing[0] not in q.fits:
        return answer
    first = answer.missing[0]
    together = needed_beside(q.observations, q.own, q.base, q.fits, first, q.screening)
    if any(set(answer.missing) <= set(more.effects) for more in together):
        # Each is needed beside the others: that tells them apart.
        return Answer(*verdict_of([find_definition(first, q.own)]), together)
    return Answer(answer.verdict, answer.missing, together)


def verdict_of_pair(pair: Together, own: Sequence[Definition]) -> tuple[str, tuple[str, ...]]:
    """The verdict on two effects that count only together: the cause of more evidence is named."""
    entries = [find_definition(key, own) for key in pair.effects]
    causes = [entry for entry in entries if entry.names_cause]
    return verdict_of(causes[:1] or entries)
