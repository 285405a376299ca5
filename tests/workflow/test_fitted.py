"""Stored models made ready."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from avahazard.workflow.fitted import exact_volumes, fitted_posterior, offset_array

from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.event import Event
from avahazard.workflow.stored_model import load_stored
from tests.workflow.worlds import bowl

EVENTS = tuple(
    Event(f"e{k}", path_id="B", runout_elevation_m=400.0, volume_m3=v)
    for k, v in enumerate((1e4, 2e4, 4e4, None))
)


def test_volumes_as_recorded() -> None:
    observations = build_observations(bowl(events=EVENTS))
    volumes = exact_volumes(observations)
    np.testing.assert_allclose(np.exp(volumes.log_volume[:3, 0]), [1e4, 2e4, 4e4])
    np.testing.assert_array_equal(volumes.sd[:3], 0.0)
    assert volumes.sd[3] > 0.0
    assert volumes.log_volume[3, 0] == observations.volumes.mean[3]


def test_the_papers_methods_take_volumes_as_exact(snow_database: str) -> None:
    stored, records = load_stored(snow_database, "base")
    spread = fitted_posterior(stored, records)
    exact = fitted_posterior(replace(stored, method="gibbs"), records)
    assert np.all(spread.observations.volumes.sd > 0.0)
    assert np.all(exact.observations.volumes.sd == 0.0)


def test_offsets_of_paths_not_seen_come_from_the_spread() -> None:
    base = bowl(events=EVENTS)
    names = [f"P{k}" for k in range(5)]
    records = replace(
        base,
        paths=tuple(replace(base.paths[0], path_id=n) for n in names),
        profiles=tuple(replace(base.profiles[0], path_id=n) for n in names),
        events=tuple(replace(EVENTS[0], event_id=n, path_id=n) for n in names),
    )
    observations = build_observations(records)
    specification, facts = with_effects(observations, Specification(), ["path-effect"])
    posterior = assemble(observations, specification, facts)
    u = np.tile([s.mean for s in posterior.layout.slots], (5000, 1))
    u[:, posterior.layout.path_scatter] = 0.5
    known = {n: np.full(5000, 0.25) for n in names[:4]}
    found = offset_array(posterior, u, known, np.random.default_rng(1))
    assert found is not None
    np.testing.assert_array_equal(found[:, :4], 0.25)
    assert abs(found[:, 4].std() - 0.5 * 0.2) < 0.005
    plain = assemble(observations, Specification(), {})
    assert offset_array(plain, u, {}, np.random.default_rng(1)) is None
