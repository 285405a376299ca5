"""Levels of all that can lead to a name.

Where nothing is missing something is named in at most 5 of 100 cases: that is what the levels add
up to, however the tests depend on each other (Bonferroni).
"""

from __future__ import annotations

LEVEL = 0.03
"""Family-wise level of the candidates."""
EXPECTED_SHARE = 2.0 / 3.0
"""Share of that level for candidates that were expected before anybody looked."""
LASTING_LEVEL, PASSING_LEVEL = 0.003, 0.001
"""Levels of groups of events, each tested by itself: of those that last, as paths, and of winters
and of storms, which must have evidence besides."""
SIGHT_LEVEL = 0.01
"""Level of what says which avalanches were recorded at all, tested by itself."""
PAIR_LEVEL = 0.005
"""Level of pairs of which neither shows alone."""


def group_level(lasting: bool) -> float:
    """Level of the test of groups that last, or do not come again."""
    return LASTING_LEVEL if lasting else PASSING_LEVEL
