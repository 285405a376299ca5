"""The climate warms: friction falls with the years."""

from avahazard.effects.effect import Parameter

KEY = "warming"
MEANING = "Winters warm from 1950 on. Friction falls in a line with the years since."
NEEDS = ["date"]
PARAMETERS = [Parameter("fall", "log friction a century", 0.0, 0.0, 0.5)]


def friction(columns):
    """Centuries since 1950."""
    return [-((columns.year - 1950.0).clip(0.0) / 100.0)]
