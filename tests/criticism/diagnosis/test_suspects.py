"""Records that are hard to believe."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis.suspects import FAR, suspects

OFF = np.array([0.5, FAR + 2.0, FAR - 0.1, -FAR - 5.0, 99.0])
"""By how many scatters each event's log friction is off; the last one left its profile."""


@pytest.mark.parametrize("in_log", [True, False])
def test_the_far_ones_are_named_worst_first(in_log: bool) -> None:
    scatter, middle = 0.02, (-0.8 if in_log else 0.5)
    place = middle + scatter * OFF
    nodes = SimpleNamespace(
        place=place[:, None], weight=np.ones((5, 1)), is_probability=np.arange(5) == 4
    )
    base: Any = SimpleNamespace(
        mode=SimpleNamespace(u=np.zeros(1)),
        posterior=SimpleNamespace(
            location_and_scatter=lambda _u: (np.full((5, 2), middle), np.full((5, 2), scatter)),
            nodes=SimpleNamespace(at=lambda _u: nodes),
            layout=SimpleNamespace(log_scatter=in_log),
            observations=SimpleNamespace(
                columns=SimpleNamespace(
                    event_id=np.array(["a", "b", "c", "d", "e"]),
                    log_volume=np.log([1e3, 2e3, 4e6, 1e4, 3e3]),
                )
            ),
        ),
    )
    assert suspects(base) == ("c", "d", "b")
