"""A path without volumes: its rate alone."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import numpy as np
import pytest

from avahazard.hazard.frequency import Frequencies, KnownVolumes
from avahazard.hazard.volume_region import VolumeRecord, region_of
from avahazard.hazard.volume_source import VolumeSource
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.records.path import Path


@pytest.fixture
def frequencies() -> Frequencies:
    """Twelve events in thirty years of path p, and no volume."""
    none = np.empty(0)
    record = VolumeRecord("p", 1971, 2000, "a test", 12, 9, 0, none, none, none, none)
    refused = {"p": AvahazardError("There are no volumes.", "Measure some.")}
    return Frequencies(region_of([record]), refused, 5, VolumeSource(), None, None, {})


def test_its_rate_is_that_of_a_poisson_process(frequencies: Frequencies) -> None:
    with pytest.raises(AvahazardError, match="no volumes"):
        frequencies.of("p")
    found = frequencies.rate_alone("p")
    assert found is not None
    # Jeffreys' prior: gamma of shape n + 1/2.
    assert np.mean(found.rate) == pytest.approx(12.5 / 30.0, rel=0.02)
    assert np.std(found.rate) == pytest.approx(12.5**0.5 / 30.0, rel=0.05)
    assert (found.share == 1.0).all()
    assert frequencies.rate_alone("nobody") is None


def test_it_is_trusted_for_twice_the_observed_years(frequencies: Frequencies) -> None:
    assert not frequencies.extrapolated("p", 60.0)
    assert frequencies.extrapolated("p", 60.5)


def held(thing: object) -> Iterator[object]:
    """All that an object leads to."""
    seen: set[int] = set()
    left = [thing]
    while left:
        one = left.pop()
        if id(one) not in seen and not isinstance(one, type):
            seen.add(id(one))
            yield one
            left += gc.get_referents(one)


def test_a_refusal_holds_no_records() -> None:
    known = KnownVolumes()
    known.add(Path("P"), (Event("e", "P", runout_x_m=1.0),))
    assert isinstance(known.refused["P"], AvahazardError)
    assert not any(isinstance(thing, Event) for thing in held(known))


def test_any_area_of_release_over_nought_is_known() -> None:
    known = KnownVolumes()
    for name, area in (("small", 0.5), ("none", 0.0), ("words", "steep")):
        known.add(Path(name, covariates={"release_area_m2": area}), (Event("e", name),))
    assert known.areas == {"small": 0.5}
