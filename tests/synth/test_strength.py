"""At strength 1 an effect is plain to one who knows it."""

from __future__ import annotations

import pytest

from avahazard.synth.effects import CATALOGUE
from tests.synth.oracle import gain


@pytest.mark.slow
@pytest.mark.parametrize("key", [*CATALOGUE, "covariate:new_snow_cm"])
def test_gain_is_clearly_over_ten_nats(key: str) -> None:
    assert gain(101, key) > 12.0
