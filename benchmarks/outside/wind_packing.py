"""Snow packed by strong wind is smooth: friction falls above 8 m/s."""

import numpy as np

from avahazard.effects.effect import Parameter

KEY = "wind-packing"
MEANING = "Strong wind packs the surface smooth. Friction falls in a step about 8 m/s."
NEEDS = ["wind_m_s"]
PARAMETERS = [Parameter("fall", "log friction", neutral=0.0, prior_mean=0.0, prior_sd=0.3)]


def friction(columns):
    """The share of the fall at each event's wind."""
    return [-1.0 / (1.0 + np.exp(-(columns.numbers["wind_m_s"] - 8.0)))]
