"""Family-wise levels, with and without effects that were declared beforehand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.stats import gamma

from avahazard.criticism.screening.significance import (
    DETECTION_LEVEL,
    LEVEL,
    PAIR_LEVEL,
    Screened,
    group_level,
    judge,
)
from avahazard.effects.catalogue import catalogue, definition

ENTRIES = [entry for entry in catalogue().values() if not entry.in_base][:8]
KEYS = [entry.key for entry in ENTRIES]


def judged(real: np.ndarray, null: np.ndarray, expected: Sequence[str] = ()) -> dict[str, Screened]:
    gains = np.vstack([real, null])
    found = judge(ENTRIES, gains, np.zeros(len(gains)), (), np.empty((len(gains), 0)), expected)
    return {c.key: c for c in found.candidates}


def gains(rng: np.random.Generator, n: int) -> np.ndarray:
    return 0.5 * rng.chisquare(1, (n, len(KEYS)))


def test_what_was_declared_is_not_one_of_many() -> None:
    rng = np.random.default_rng(1)
    null = gains(rng, 999)
    real = gains(rng, 1)[0] * 0.1
    real[3] = 3.6  # p about 0.007 alone
    open_ended = judged(real, null)[KEYS[3]].p_family
    declared = judged(real, null, [KEYS[3]])[KEYS[3]].p_family
    assert open_ended > LEVEL > declared
    # The others pay for it, unless the declared one is significant.
    assert judged(real, null, [KEYS[0]])[KEYS[3]].p_family >= 2.0 * open_ended


def test_the_rest_has_the_whole_level_once_all_declared_ones_are_significant() -> None:
    rng = np.random.default_rng(2)
    null = gains(rng, 499)
    real = gains(rng, 1)[0] * 0.1
    real[[0, 5]] = 12.0
    both = judged(real, null, [KEYS[0]])
    assert both[KEYS[0]].p_family <= LEVEL
    assert both[KEYS[5]].p_family <= judged(real, null)[KEYS[5]].p_family


def test_the_level_is_kept_whatever_is_declared() -> None:
    """Among worlds in which nothing is missing, some effect is significant in at most 3 %."""
    rng = np.random.default_rng(3)
    null = gains(rng, 199)
    worlds = gains(rng, 100)
    for expected in ((), KEYS[:3]):
        alarms = [
            min(c.p_family for c in judged(real, null, expected).values()) <= LEVEL
            for real in worlds
        ]
        assert np.mean(alarms) < LEVEL + 3.0 * np.sqrt(LEVEL / len(worlds))


def test_what_is_seen_is_tested_by_itself() -> None:
    """Its p-value is three times its rank, whatever else is tried; theirs know nothing of it."""
    rng = np.random.default_rng(4)
    entries = [*ENTRIES, definition("observation-limit")]
    null = np.column_stack([gains(rng, 199), rng.gamma(9.0, 1.0, 199)])
    real = np.append(gains(rng, 1)[0] * 0.1, 20.0)
    none = np.empty((200, 0))
    found = judge(entries, np.vstack([real, null]), np.zeros(200), (), none)
    sight = next(c for c in found.candidates if c.key == "observation-limit")
    rank = (1.0 + np.sum(null[:, -1] >= 20.0)) / 200.0
    assert sight.p_family == pytest.approx(rank * LEVEL / DETECTION_LEVEL)
    assert sight.p_single == pytest.approx(gamma.sf(20.0, 9.0), rel=0.9)
    # Two of 200 are enough.
    assert sight.p_family <= LEVEL
    alone = judged(real[:-1], null[:, :-1])
    for c in found.candidates:
        if c.key != "observation-limit":
            assert c.p_family == alone[c.key].p_family


def test_what_a_limit_gains_by_chance_counts_by_half() -> None:
    """A gain like any other is plain where little of it is chance, and none where all may be."""
    rng = np.random.default_rng(6)
    chance = rng.gamma(9.0, 1.0, 199)
    null = (chance + rng.gamma(1.0, 1.0, 199))[:, None]
    entries, none = [definition("observation-limit")], np.empty((200, 0))
    found = {}
    for limit in (3.0, 14.0):
        gains = np.vstack([[14.0], null])
        (found[limit],) = judge(entries, gains, np.append(limit, chance), (), none).candidates
    left = null[:, 0] - 0.5 * chance
    for limit, sight in found.items():
        rank = (1.0 + np.sum(left >= 14.0 - 0.5 * limit)) / 200.0
        assert sight.p_family == pytest.approx(min(rank * LEVEL / DETECTION_LEVEL, 1.0))
        assert sight.gain == 14.0
        assert sight.null_mean == pytest.approx(float(np.mean(null)))
    assert found[3.0].p_family <= LEVEL < found[14.0].p_family


def test_the_levels_of_all_that_is_tested_add_up_to_five_percent() -> None:
    groups = [entry for entry in catalogue().values() if entry.nuisance is not None]
    lasting = [entry.key == "path-effect" for entry in groups]
    levels = [LEVEL, DETECTION_LEVEL, PAIR_LEVEL, *(group_level(lasts) for lasts in lasting)]
    assert sum(levels) == pytest.approx(0.05)


def test_groups_are_held_against_levels_of_their_own() -> None:
    rng = np.random.default_rng(5)
    null = gains(rng, 199)
    groups = [("path-effect", group_level(True)), ("winter-effect", group_level(False))]
    # p about 0.002 each.
    gain = np.vstack([np.full(2, 4.8), gains(rng, 199)[:, :2]])
    found = judge(ENTRIES, null[[0, *range(199)]], np.zeros(200), groups, gain)
    path, winter = found.groups
    assert path.p_value <= path.level
    assert winter.p_value > winter.level
