"""The verdict of a diagnosis in words."""

from __future__ import annotations

from avahazard.report.html.words import chance, likelier
from avahazard.results.amounts import amount
from avahazard.results.diagnosis import Diagnosis


def verdict_words(diagnosis: Diagnosis, who: str = "The model") -> str:
    """What a diagnosis says of the model, and where the records have what is missing."""
    return " ".join([_verdict(diagnosis, who), *_together(diagnosis), *diagnosis.where])


def _together(diagnosis: Diagnosis) -> list[str]:
    """What is needed together, the largest set that was found."""
    if not diagnosis.pairs:
        return []
    last = diagnosis.pairs[-1]
    names = f"{', '.join(last.effects[:-1])} and {last.effects[-1]}"
    more, floor = likelier(last.gain_over_best_single), 1.0 / (diagnosis.n_worlds + 1)
    return [
        f"Needed together: {names}. With all of them the records are {more} likelier than with the "
        f"best of them alone (p {chance(last.p_value, floor)})."
    ]


def _verdict(diagnosis: Diagnosis, who: str) -> str:
    missing = ", ".join(diagnosis.missing)
    if diagnosis.verdict == "missing-effect":
        return f"{who} lacks an effect: {missing}."
    if diagnosis.verdict == "ambiguous":
        return f"{who} lacks an effect, and these data cannot tell which: {missing}."
    if diagnosis.verdict == "unexplained":
        return (
            f"{who} fails along {missing}, and no effect of the catalogue explains it: look at "
            "its shape, and write an effect of your own (avahazard effect new FILE)."
        )
    size = amount(diagnosis.detectable_m, diagnosis.coordinate, 0)
    return (
        f"{who} is adequate: these data show no missing effect. One that moves runouts by "
        f"{size} (rms) would have been seen 4 times in 5."
    )
