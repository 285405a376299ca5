"""The verdict of a diagnosis in words."""

from __future__ import annotations

from avahazard.report.html.words import amount, chance, likelier, listed
from avahazard.report.language import ENGLISH, Language
from avahazard.results.diagnosis import Diagnosis


def verdict_words(
    diagnosis: Diagnosis, who: str | None = None, language: Language = ENGLISH
) -> str:
    """What a diagnosis says of the model, and where the records have what is missing."""
    where = [language.note(note) for note in diagnosis.where]
    whose = language.say("The model") if who is None else who
    return " ".join([_verdict(diagnosis, whose, language), *_together(diagnosis, language), *where])


def _together(diagnosis: Diagnosis, language: Language) -> list[str]:
    """What is needed together, the largest set that was found."""
    if not diagnosis.pairs:
        return []
    last = diagnosis.pairs[-1]
    return [
        language.say(
            "Needed together: {effects}. With all of them the records are {times} likelier than "
            "with the best of them alone (p {p}).",
            effects=listed([language.effect(key) for key in last.effects], language),
            times=likelier(last.gain_over_best_single, language),
            p=chance(last.p_value, 1.0 / (diagnosis.n_worlds + 1), language),
        )
    ]


def _verdict(diagnosis: Diagnosis, who: str, language: Language) -> str:
    say = language.say
    missing = ", ".join(language.effect(key) for key in diagnosis.missing)
    if diagnosis.verdict == "missing-effect":
        return say("{who} lacks an effect: {missing}.", who=who, missing=missing)
    if diagnosis.verdict == "ambiguous":
        return say(
            "{who} lacks an effect, and these data cannot tell which: {missing}.",
            who=who,
            missing=missing,
        )
    if diagnosis.verdict == "unexplained":
        return say(
            "{who} fails along {missing}, and no effect of the catalogue explains it: look at its "
            "shape, and write an effect of your own (avahazard effect new FILE).",
            who=who,
            missing=missing,
        )
    if diagnosis.cannot_tell:
        return say(
            "{who} shows no missing effect, but these data cannot tell: one behind half of the "
            "scatter could have been missed. One that moves runouts by {size} (rms) would have "
            "been seen 4 times in 5.",
            who=who,
            size=amount(diagnosis.detectable_m, diagnosis.coordinate, 0, language),
        )
    return say(
        "{who} is adequate: these data show no missing effect. One that moves runouts by {size} "
        "(rms) would have been seen 4 times in 5.",
        who=who,
        size=amount(diagnosis.detectable_m, diagnosis.coordinate, 0, language),
    )
