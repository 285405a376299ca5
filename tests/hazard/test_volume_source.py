"""What may be said of where volumes come from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avahazard.hazard.volume_source import VolumeSource
from avahazard.records.errors import AvahazardError


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"threshold_m3": 5e3}, "--threshold"),
        ({"table": Path("v.csv"), "as_of": 2000}, "--as-of"),
        ({"family": "gpd", "threshold_m3": -1.0}, "The threshold is -1"),
    ],
)
def test_what_cannot_be(given: dict[str, Any], named: str) -> None:
    with pytest.raises(AvahazardError, match=named):
        VolumeSource(**given)
