"""The spread between groups of events that share an offset of log friction."""

from __future__ import annotations

from avahazard.effects.effect import Parameter

SPREAD = 0.2
"""Scale of the half-normal prior, on log friction. The seven paths of Ancey (2005), whose log a
differs with a standard deviation of 0.09, lie in its middle half."""


def spread_parameter(name: str) -> Parameter:
    """The spread τ between groups; `name` is its own among all spreads."""
    return Parameter(name, "log friction", 0.0, 0.0, SPREAD, 0.0)
