"""Scales of the stated errors: the likelihood is that of records that state the scaled ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.effects.catalogue import catalogue
from avahazard.effects.effect import RecordErrorEffect, VolumeErrorEffect
from avahazard.inference.fitting.mode import Mode, find_mode, log_evidence
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.volumes import VolumeNodes
from avahazard.records.collection import Records
from tests.inference import studies
from tests.inference.misstated import misstated

RECORD, VOLUME = (
    key
    for kind in (RecordErrorEffect, VolumeErrorEffect)
    for key, entry in catalogue().items()
    if entry.changes is None
    and entry.lacking(studies.observations().columns, studies.observations().sites) is None
    and isinstance(
        entry.build(entry.facts(studies.observations().columns, studies.observations().sites)), kind
    )
)
FIELD = {RECORD: "runout_sigma_m", VOLUME: "volume_rel_sigma"}


def _stated(key: str, factor: float, given: Records) -> Observations:
    """The records with errors stated `factor` times as large."""
    field = FIELD[key]
    events = tuple(replace(e, **{field: factor * getattr(e, field)}) for e in given.events)
    return build_observations(replace(given, events=events))


@pytest.mark.parametrize("key", [RECORD, VOLUME])
@pytest.mark.parametrize("factor", [0.4, 2.3])
@pytest.mark.parametrize("settings", [{}, {"tails": "student", "scatter": "volume"}])
def test_a_factor_is_what_records_with_such_errors_give(
    key: str, factor: float, settings: dict[str, str]
) -> None:
    told = studies.posterior(_stated(key, factor, studies.records()), **settings)
    scaled = studies.posterior(studies.observations(), key, **settings)
    # The volume by which scatter is measured is a setting, of the stated errors.
    told = studies.assemble(told.observations, replace(scaled.specification, effects=()), {})
    u = studies.near(told, 0.1, 6)
    named = {s.name: v for s, v in zip(told.layout.slots, u, strict=True)}
    for slot in scaled.layout.slots:
        if slot.name.startswith(key):
            named[slot.name] = np.log(factor) / slot.scale
    with_factor = np.array([named[s.name] for s in scaled.layout.slots])
    exact = told.exact_log_likelihood(u)
    # Not to the last bit: panels of friction are those of the largest errors.
    assert scaled.exact_log_likelihood(with_factor) == pytest.approx(exact, abs=1e-4)
    away = scaled.exact_log_likelihood(_at_neutral(scaled, with_factor))
    assert abs(away - exact) > 0.1


def _at_neutral(model: Posterior, u: np.ndarray) -> np.ndarray:
    return np.where([s.neutral == 0.0 for s in model.layout.slots], 0.0, u)


def _fitted(given: Observations, *keys: str) -> tuple[Posterior, Mode]:
    model = studies.posterior(given, *keys)
    return model, find_mode(model)


def _factor(given: Observations, key: str) -> float:
    model, mode = _fitted(given, key)
    return float(np.exp(model.layout.effect_values(mode.u)[key][0]))


@pytest.mark.parametrize("truth", [1.0, 3.0])
def test_the_factor_of_the_records_comes_back(truth: float) -> None:
    assert _factor(misstated(truth, 1.0, 11), RECORD) == pytest.approx(truth, rel=0.35)


@pytest.mark.parametrize("truth", [0.5, 1.0, 2.5])
def test_the_factor_of_the_volumes_comes_back(truth: float) -> None:
    assert _factor(misstated(1.0, truth, 12), VOLUME) == pytest.approx(truth, rel=0.35)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("record", "volume", "best"), [(3.0, 1.0, RECORD), (1.0, 2.5, VOLUME), (1.0, 1.0, None)]
)
def test_the_evidence_tells_which_errors_are_misstated(
    record: float, volume: float, best: str | None
) -> None:
    given = misstated(record, volume, 13)
    plain = log_evidence(*_fitted(given)).value
    gains = {key: log_evidence(*_fitted(given, key)).value - plain for key in (RECORD, VOLUME)}
    for key, gain in gains.items():
        assert gain > 5.0 if key == best else gain < 3.0


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_volumes_are_as_uncertain_as_the_factor_says(factor: float) -> None:
    model = studies.posterior(studies.observations(), VOLUME)
    (slot,) = (s for s in model.layout.slots if s.name.startswith(VOLUME))
    u = studies.near(model)
    u[model.layout.places[VOLUME]] = np.log(factor) / slot.scale
    own, told = studies.observations().volumes, model.volumes(u)

    def spread(volumes: VolumeNodes) -> np.ndarray:
        log = np.log(volumes.volume)
        mean = np.sum(volumes.weight * log, axis=1, keepdims=True)
        return np.sqrt(np.sum(volumes.weight * (log - mean) ** 2, axis=1))

    assert np.all((spread(told) > spread(own)) == (factor > 1.0))
