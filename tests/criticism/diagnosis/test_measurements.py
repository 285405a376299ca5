from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis import measurements
from avahazard.criticism.diagnosis.measurements import (
    expected_speeds,
    measurement_gains,
    record_gain,
    speed_gains,
    tracks_of,
)
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit, refit, refit_with
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.seeds import generator
from avahazard.results.diagnosis import FIELD_DAYS
from tests.criticism.lengths import lengths
from tests.inference import studies


@pytest.fixture(scope="module")
def base() -> Refit:
    return refit(studies.observations(speeds=False), Specification(), {})


@pytest.fixture(scope="module")
def drag(base: Refit) -> Refit:
    """The model with much drag."""
    return with_drag(base, 1.2)


def with_drag(base: Refit, value: float) -> Refit:
    found = refit_with(base, "turbulent-drag")
    slot = found.posterior.layout.places["turbulent-drag"].start
    found.mode.u[slot] = found.sample[:, slot] = value
    return replace(found, posterior=found.posterior.exactly())


def gains(first: Refit, second: Refit) -> np.ndarray:
    """Of speeds along the first track `[n_places + 1]`."""
    track = tracks_of(first.observations)[0]
    pair = [expected_speeds(fit, [track]) for fit in (first, second)]
    each = [
        speed_gains((pair[0][e[0]], pair[1][e[0]]), track.x, e, 0.05, generator(1, "test"))
        for e in track.events
    ]
    return np.mean(each, axis=0)


def test_speeds_part_what_moves_at_other_speeds(base: Refit, drag: Refit) -> None:
    assert not np.any(gains(base, base))
    weak, strong = gains(with_drag(base, 0.4), base), gains(drag, base)
    assert len(strong) == 9
    assert 0.0 < np.max(weak[:-1]) < np.max(strong[:-1]) < strong[-1]
    assert gains(base, drag) == pytest.approx(strong, rel=0.3, abs=0.05)


def test_a_place_gains_what_measuring_there_gains(base: Refit, drag: Refit) -> None:
    """The gain is the mean log likelihood ratio of the simulated speeds: an obvious twin."""
    track = tracks_of(base.observations)[0]
    track = track._replace(x=track.x[3:4])
    event, release, stop = track.events[0]
    pair = [expected_speeds(fit, [track])[event] for fit in (drag, base)]
    found = speed_gains((pair[0], pair[1]), track.x, track.events[0], 0.1, generator(1, "test"))
    mean = np.mean([fit.chance @ fit.speeds[:, 0] for fit in pair])
    own = 0.1**2 * measurements.track_spread(track.x - release, stop - release)
    sigma = np.sqrt(own[0, 0] + 1.5**2 * (4.0 * mean**2 + 2.0 * 1.5**2))
    grid = np.linspace(0.0, 90.0**2, 20001)
    densities = [
        np.sum(f.chance[:, None] * np.exp(-0.5 * ((grid - f.speeds**2) / sigma) ** 2), axis=0)
        for f in pair
    ]
    p, q = (np.maximum(d, 1e-300) / (sigma * np.sqrt(2.0 * np.pi)) for d in densities)
    exact = 0.5 * np.trapezoid((p - q) * (np.log(p) - np.log(q)), grid)
    assert found == pytest.approx(np.array([exact, exact]), rel=0.35)


def test_the_fewest_days_come_first(base: Refit, drag: Refit) -> None:
    pair = {"turbulent-drag": drag, "": base}
    found = measurement_gains(pair, FIELD_DAYS)
    days = [m.field_days for m in found]
    assert days == sorted(days)
    assert all(m.expected_gain >= MARGIN and m.between == ("turbulent-drag",) for m in found)
    assert found == measurement_gains(pair, FIELD_DAYS)
    speed = next(m for m in found if m.x_m is not None)
    assert speed.path_id in base.observations.columns.paths
    assert f"path {speed.path_id} at x = {speed.x_m:,.0f} m" in speed.measurement
    # Where a speed costs a month, all else comes first; where it costs an hour, nothing.
    dear, cheap = (measurement_gains(pair, FIELD_DAYS | {"speed": days}) for days in (30.0, 0.1))
    assert dear[-1].measurement == speed.measurement == cheap[0].measurement
    assert dear[-1].field_days == 15.0 * (speed.field_days or 0.0)


def test_nothing_is_advised_between_equals(base: Refit) -> None:
    assert not measurement_gains({"turbulent-drag": base, "": base}, FIELD_DAYS)


def test_kinds_of_avalanche_that_differ_most(base: Refit) -> None:
    snow = refit_with(base, "snow-type")
    snow.mode.u[snow.posterior.layout.places["snow-type"]] = 0.4
    best = measurement_gains({"snow-type": snow, "": base}, FIELD_DAYS)[0]
    assert "more avalanche" in best.measurement
    gain, columns = record_gain(snow, base), base.observations.columns
    kinds = [gain, *(gain[columns.path_index == k] for k in range(len(columns.paths)))]
    most = max(float(np.mean(kind)) for kind in kinds if len(kind) >= 5)
    assert best.expected_gain / (best.field_days or np.nan) >= 0.999 * most


def test_errors_of_volumes_are_seen_by_a_survey(base: Refit) -> None:
    errors = refit_with(base, "volume-error")
    errors.mode.u[errors.posterior.layout.places["volume-error"]] = np.log(2.0)
    found = measurement_gains({"volume-error": errors, "": base}, FIELD_DAYS)
    survey = next(m for m in found if "surveyed to 10 %" in m.measurement)
    volumes = base.observations.volumes
    stated = volumes.population.factor * volumes.records.sigma
    (log_factor,) = errors.posterior.layout.effect_values(errors.mode.u)["volume-error"]
    ratio = (np.exp(2.0 * log_factor) * stated**2 + 0.01) / (stated**2 + 0.01)
    each = float(np.mean(ratio + 1.0 / ratio - 2.0)) / 4.0
    assert survey.expected_gain == pytest.approx(np.ceil(MARGIN / each) * each)


def test_without_a_profile_only_events_can_be_measured() -> None:
    observations = build_observations(lengths(60, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    other = refit(observations, base.specification, base.facts, ("covariate:column_1",), (), base)
    found = measurement_gains({"covariate:column_1": other, "": base}, FIELD_DAYS)
    assert len(found) == 1
    assert "more avalanches" in found[0].measurement
    # As many more events as there are would gain as much as these did.
    gained = other.log_likelihood - base.log_likelihood
    assert float(np.sum(record_gain(other, base))) == pytest.approx(gained, rel=0.3)


def test_columns_that_go_together_are_to_be_parted() -> None:
    observations = build_observations(lengths(60, slope=0.1))
    base = refit(observations, Specification(law="power"), {})
    keys = [f"covariate:column_{k}" for k in (1, 2)]
    pair = {
        key: refit(observations, base.specification, base.facts, (key,), (), base) for key in keys
    }
    tried = [t.key for t in measurements._events(*pair.values())]
    assert "measure_unlinked" in tried
