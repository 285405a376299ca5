"""What settings of the model need of the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.covariate import VOLUME_LAW, VOLUME_SCATTER
from avahazard.effects.motion import CENTRIFUGAL
from tests.effects.event_table import event_table
from tests.effects.examples import columns


@pytest.mark.parametrize(
    ("log_volume", "enough"),
    [([9.0, 10.0], True), ([9.0, np.nan], False), ([9.0, 9.0], False), ([np.nan] * 2, False)],
)
def test_volumes_must_differ(log_volume: list[float], enough: bool) -> None:
    table = replace(event_table(a=[0.0, 1.0]), log_volume=np.array(log_volume))
    assert (VOLUME_LAW.lacking(table, ()) is None) == enough
    assert (VOLUME_SCATTER.lacking(table, ()) is None) == enough


def test_a_profile_is_that_of_an_events_path() -> None:
    assert CENTRIFUGAL.lacking(columns(), ()) is None
    assert CENTRIFUGAL.lacking(event_table(), ()) is not None
