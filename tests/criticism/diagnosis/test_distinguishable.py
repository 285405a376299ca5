from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.criticism.diagnosis.measurements import correlation, explained
from avahazard.criticism.diagnosis.refits import refit
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Records
from tests.criticism.lengths import lengths
from tests.inference import studies


def with_copy(records: Records) -> Records:
    """The records with a column that is nearly the first one."""
    noise = np.random.default_rng(9).normal(0.0, 0.05, len(records.events))
    events = tuple(
        replace(e, covariates={**e.covariates, "copy": e.covariates["column_1"] + noise[i]})
        for i, e in enumerate(records.events)
    )
    return replace(records, events=events)


def test_effects_of_nearly_equal_columns_look_alike_and_others_do_not() -> None:
    observations = build_observations(with_copy(lengths(90, slope=0.15)))
    base = refit(observations, Specification(law="power"), {})
    change = {
        name: explained(
            refit(observations, base.specification, base.facts, (f"covariate:{name}",), (), base),
            base,
        )
        for name in ("column_1", "copy", "column_2")
    }
    assert correlation(change["column_1"], change["copy"], base.posterior) > 0.9
    assert abs(correlation(change["column_1"], change["column_2"], base.posterior)) < 0.5


def test_an_effect_explains_its_own_column() -> None:
    observations = build_observations(lengths(90, slope=0.15))
    base = refit(observations, Specification(law="power"), {})
    fit = refit(observations, base.specification, base.facts, ("covariate:column_1",), (), base)
    column = observations.columns.numbers["column_1"]
    assert abs(np.corrcoef(explained(fit, base), column)[0, 1]) > 0.9


def test_what_law_and_paths_can_do_counts_for_nothing() -> None:
    observations = studies.observations(speeds=False)
    model = studies.posterior(observations)
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, observations.n_events))
    by_path = 3.0 * (observations.columns.path_index == 2)
    by_volume = 2.0 * observations.volumes.mean
    assert correlation(a, a, model) == pytest.approx(1.0)
    assert correlation(a, -a, model) == pytest.approx(-1.0)
    moved = correlation(a + by_path, b - by_volume, model)
    assert moved == pytest.approx(correlation(a, b, model), abs=1e-9)
    assert correlation(by_path, a, model) == 0.0
