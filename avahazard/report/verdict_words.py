"""The verdict of a diagnosis in words."""

from __future__ import annotations

from avahazard.results.diagnosis import Diagnosis


def verdict_words(diagnosis: Diagnosis, who: str = "The model") -> str:
    """What a diagnosis says of the model, in a sentence."""
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
    return (
        f"{who} is adequate: these data show no missing effect. One that moves runouts by "
        f"{diagnosis.detectable_m:.0f} m (rms) would have been seen 4 times in 5."
    )
