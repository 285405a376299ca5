"""A detection limit that hides most stops of each path: what is left says little, and no wonder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.criticism.screening.screen import screen
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import ELEVATION, Observations
from tests.inference import studies


def just_seen() -> Observations:
    """Events whose highest stop of each path is the highest that would be seen."""
    observations = studies.observations(n_events=48, speeds=False)
    path = observations.columns.path_index
    limit = observations.limit.copy()
    for k in range(len(observations.columns.paths)):
        selected = (path == k) & (observations.kind == ELEVATION)
        limit[path == k] = np.max(observations.observed[selected]) + 1.0
    return replace(observations, limit=limit)


def test_larger_errors_gain_nothing_wild_where_stops_are_hardly_seen() -> None:
    model = studies.posterior(just_seen(), "path-effect")
    entries = [find_definition(key) for key in ("record-error", "season")]
    found = screen(model, studies.near(model), entries, n_worlds=40)
    assert {c.key for c in found.candidates} == {"record-error", "season"}
    assert all(0.0 <= c.gain < 12.0 for c in found.candidates)
    assert np.isfinite(found.largest).all()
