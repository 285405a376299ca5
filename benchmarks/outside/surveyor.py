"""One of the surveyors writes down places that lie too high."""

from avahazard.effects.effect import Parameter

KEY = "surveyor-bias"
MEANING = "The records of surveyor B lie too high. The others are right."
NEEDS = ["surveyor"]
PARAMETERS = [
    Parameter("shift", "m", neutral=0.0, prior_mean=0.0, prior_sd=40.0, low=-120.0, high=120.0)
]


def record_shift(columns, shift):
    """Metres by which each record lies too high."""
    return shift * (columns.texts["surveyor"] == "B")
