"""Snow near melting glides on a film of water: friction falls from -4 °C on."""

import numpy as np

from avahazard.effects.effect import Parameter

KEY = "warm-snow"
MEANING = "Snow near melting glides on a film of water. Friction falls in a line from -4 °C to 0."
NEEDS = ["snow_temperature_c"]
PARAMETERS = [Parameter("fall", "log friction", neutral=0.0, prior_mean=0.0, prior_sd=0.3)]


def friction(columns):
    """The share of the fall at each event's temperature."""
    return [-np.clip((columns.numbers["snow_temperature_c"] + 4.0) / 4.0, 0.0, 1.0)]
