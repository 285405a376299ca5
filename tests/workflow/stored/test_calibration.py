"""What a calibration found, summed up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from avahazard.inference.likelihood.assemble import assemble
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.prediction.fitted_model import FittedModel, fitted_model
from avahazard.inference.samplers.chains import chains
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.fingerprint import data_fingerprint
from avahazard.workflow.stored.calibration import calibration_result, mode, summary
from tests.criticism.studies import straight
from tests.workflow.worlds import bowl


def _found(draws: np.ndarray, offsets: Mapping[str, np.ndarray], **others: Any) -> FittedModel:
    names = ("a", "sigma")[: draws.shape[2]]
    keys = ("path-effect",) if offsets else ()
    specification = Specification(law="constant", effects=keys)
    records = straight(7)
    if offsets:
        on_path = tuple(Event(f"e{i}", "B", runout_x_m=1000.0, volume_m3=1e4) for i in range(7))
        records = bowl(events=on_path)
    posterior = assemble(build_observations(records), specification, {})
    known = draws.reshape(-1, draws.shape[2])
    rest = len(posterior.layout.slots) - known.shape[1]
    others_drawn = np.random.default_rng(0).normal(0.5, 0.01, (len(known), rest))
    model = fitted_model(posterior, np.column_stack([known, others_drawn]), offsets)
    found = chains(names, ("", "")[: len(names)], draws)
    return replace(model, sampled=found, **others)


def test_summary_of_known_draws() -> None:
    draws = np.arange(101.0)
    found = summary(draws, "m")
    assert (found.mean, found.q05, found.q95, found.unit) == (50.0, 5.0, 95.0, "m")
    assert found.sd == pytest.approx(np.sqrt(101 * 102 / 12))


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e6])
def test_the_mode_of_a_gamma_distribution(scale: float) -> None:
    draws = np.random.default_rng(1).gamma(4.0, scale, 40_000)
    # Its mode is (k - 1) θ = 3, its mean 4.
    assert mode(draws) == pytest.approx(3.0 * scale, rel=0.12)
    assert mode(-draws) == pytest.approx(-3.0 * scale, rel=0.12)


def test_a_long_tail_hardly_moves_the_mode() -> None:
    draws = np.random.default_rng(2).lognormal(0.0, 1.5, 40_000)
    # The mode is 0.1, the median 1, the mean 3.1.
    assert 0.0 < mode(draws) < 0.5


def test_the_mode_of_a_constant() -> None:
    assert mode(np.ones(100)) == 1.0
    assert mode(np.full(100, 0.1)) == 0.1


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_the_mode_at_the_ends_of_what_a_float_holds(scale: float) -> None:
    draws = np.random.default_rng(1).gamma(4.0, 1.0, 40_000)
    assert mode(draws * scale) == pytest.approx(mode(draws) * scale, rel=1e-9)
    far = np.concatenate([np.full(90, 2.0) + 1e-12 * np.arange(90), np.full(10, 1e300)])
    assert mode(far) == pytest.approx(2.0)


def test_parameters_offsets_and_settings() -> None:
    draws = np.random.default_rng(3).normal(0.5, 0.1, (4, 500, 2))
    found = _found(draws, {"B": draws[..., 0].ravel() - 0.5}, left_out={"without a volume": 2})
    result = calibration_result(found, "m", Records(), seed=5, parent="p")
    assert list(result.parameters) == ["a", "sigma", "path:B"]
    assert result.parameters["path:B"].unit == "log friction"
    assert result.parameters["a"].mean == pytest.approx(draws[..., 0].mean())
    kept = ("model", "parent", "law", "effects", "n_events", "seed")
    assert [getattr(result, key) for key in kept] == [
        "m",
        "p",
        "constant",
        ("path-effect",),
        5,
        5,
    ]
    assert result.data_fingerprint == data_fingerprint(Records())
    assert (result.chains, result.draws) == (4, 500)
    assert result.diagnostics.converged
    assert result.notes == ()


def test_chains_apart_are_said_not_to_have_converged() -> None:
    draws = np.random.default_rng(4).normal(0.5, 0.1, (4, 500, 1)) + np.arange(4)[:, None, None]
    result = calibration_result(_found(draws, {}), "m", Records(), seed=0)
    assert result.diagnostics.converged is False
    assert result.diagnostics.rhat_max > 1.5
    assert "have not converged" in result.notes[0]
