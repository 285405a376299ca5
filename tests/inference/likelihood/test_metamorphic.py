"""What a change of the records does to what they tell, whatever the records are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import sample
from avahazard.records.collection import Event, Profile, Records
from tests.criticism.lengths import lengths
from tests.workflow.worlds import bowl, known_stops

LAWS = ("exponential", "power", "constant")


def posterior(records: Records, law: str = "exponential") -> Posterior:
    return assemble(build_observations(records), Specification(law=law), {})


def places(law: str) -> list[np.ndarray]:
    """Coordinates about those of the made records."""
    start = posterior(lengths(20), law).layout
    centre = np.array([slot.mean for slot in start.slots])
    rng = np.random.default_rng(1)
    return [centre + 0.1 * rng.standard_normal(len(centre)) for _ in range(3)]


@pytest.mark.parametrize("law", LAWS)
def test_the_order_of_events_tells_nothing(law: str) -> None:
    records = lengths(20)
    first = posterior(records, law)
    turned = posterior(Records(events=records.events[::-1]), law)
    for u in places(law):
        assert turned.log_density(u) == pytest.approx(first.log_density(u), rel=1e-12)


@pytest.mark.parametrize("law", LAWS)
def test_a_record_told_twice_counts_twice(law: str) -> None:
    """But for the spread of all volumes, by which each is read: its estimate knows their number."""
    records = lengths(20)
    again = tuple(replace(e, event_id=f"{e.event_id}'") for e in records.events)
    once, double = (
        posterior(Records(events=events), law)
        for events in (records.events, (*records.events, *again))
    )
    for u in places(law):
        assert double.log_likelihood(u) == pytest.approx(2.0 * once.log_likelihood(u), abs=0.05)


def test_records_told_twice_narrow_by_the_root_of_two() -> None:
    records = lengths(40)
    again = tuple(replace(e, event_id=f"{e.event_id}'") for e in records.events)
    widths = []
    for events in (records.events, (*records.events, *again)):
        model = posterior(Records(events=events), "power")
        drawn = sample(model, n_chains=4, n_draws=300, seed=4).draws
        widths.append(drawn.std(axis=0))
    np.testing.assert_allclose(widths[0] / widths[1], np.sqrt(2.0), rtol=0.15)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scale", [0.3048, 7.0])
def test_lengths_in_another_unit_tell_the_same(law: str, scale: float) -> None:
    """All lengths times k: each record's density is that of before over k."""
    records = lengths(20)

    def measured(event: Event) -> Event:
        return replace(
            event,
            fall_height_m=scale * (event.fall_height_m or 0.0),
            runout_length_m=scale * (event.runout_length_m or 0.0),
            runout_sigma_m=scale * event.runout_sigma_m,
        )

    before = posterior(records, law)
    found = posterior(Records(events=tuple(measured(e) for e in records.events)), law)
    for u in places(law):
        expected = before.log_likelihood(u) - 20 * np.log(scale)
        assert found.log_likelihood(u) == pytest.approx(expected, abs=1e-6)


def test_a_valley_that_is_lifted_tells_the_same() -> None:
    records = bowl(events=known_stops(volume_m3=3e4))
    (profile,) = records.profiles
    up = 750.0
    lifted = Records(
        records.paths,
        (Profile("B", profile.x_m, profile.y_m + up),),
        tuple(
            e
            if e.runout_elevation_m is None
            else replace(e, runout_elevation_m=e.runout_elevation_m + up)
            for e in records.events
        ),
    )
    here, there = posterior(records, "constant"), posterior(lifted, "constant")
    for u in (np.array([-0.6, -1.5]), np.array([-0.5, -2.5])):
        assert there.log_likelihood(u) == pytest.approx(here.log_likelihood(u), abs=1e-3)
