"""Worlds in which a limit of sight hides most stops of a path: made and fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from avahazard.criticism.screening.laplace_fit import laplace_fit
from avahazard.criticism.screening.parametric_bootstrap import draw_below, simulate
from avahazard.criticism.screening.screen import screen
from avahazard.criticism.screening.screen import tested_model as model_at_mode
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import ELEVATION, Observations
from avahazard.inference.seeds import generator
from tests.inference import studies
from tests.inference.groupings import spreads

PATH_EFFECT = "path-effect"
TAU = 0.3


def just_seen() -> Observations:
    """Events whose highest stop of each path is the highest that would be seen."""
    observations = studies.observations(n_events=48, speeds=False)
    path = observations.columns.path_index
    limit = observations.limit.copy()
    for k in range(len(observations.columns.paths)):
        mine = (path == k) & (observations.kind == ELEVATION)
        limit[path == k] = np.max(observations.observed[mine]) + 1.0
    return replace(observations, limit=limit)


@pytest.mark.parametrize("student", [False, True])
@pytest.mark.parametrize("highest", [2.0, -1.0, -12.0])
def test_scatter_is_drawn_below_an_edge(student: bool, highest: float) -> None:
    z = draw_below(np.full(4000, highest), student, generator(1, student, highest))
    whole = stats.t(4) if student else stats.norm()

    def share(z: np.ndarray) -> np.ndarray:
        return np.exp(whole.logcdf(z) - whole.logcdf(highest))

    assert np.max(z) <= highest
    assert stats.kstest(z, share).pvalue > 1e-3


def test_a_path_whose_stops_are_hardly_seen_has_records_that_the_model_bears() -> None:
    observations = just_seen()
    model = studies.posterior(observations)
    groups = spreads(observations, PATH_EFFECT, tau=TAU)
    entries = [find_definition(key) for key in ("record-error", "season")]
    found = screen(model, studies.near(model), groups, entries, n_worlds=40)
    # Records far above their limit would make larger errors gain thousands of nats.
    assert np.max(found.chance.null) < 12.0
    assert np.isfinite(found.chance.largest).all()


def test_fits_of_the_model_itself_go_on_until_they_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    observations = just_seen()
    posterior = studies.posterior(observations)
    groups = spreads(observations, PATH_EFFECT, tau=TAU)
    u, season = studies.near(posterior), [find_definition("season")]
    model = model_at_mode(posterior, u, groups, season, records_alone=False)
    gains, tau = model.gains, np.array([TAU])

    def largest_rise(most: int) -> float:
        monkeypatch.setattr("avahazard.criticism.screening.gains.MOST_FITS", most)
        rises = []
        for k in range(30):
            rng = generator(5, "few seen", k)
            world = simulate(posterior, model.predicted, u, groups.plan, tau, 0.0, rng)
            moments, first = gains.reference(world)
            fit = first
            for _ in range(6):
                fit = laplace_fit(
                    moments,
                    world.left,
                    gains.base.edges,
                    gains.design,
                    fit.coefficients,
                    fit.log_scatter,
                    fit.tau,
                    gains.student,
                )
                rises.append(fit.log_likelihood - first.log_likelihood)
        return max(rises)

    assert largest_rise(8) < 0.06 < largest_rise(1)
