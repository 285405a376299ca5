from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis import misstated_volumes, verdict
from avahazard.criticism.diagnosis.misstated_volumes import (
    by_misstated_volumes,
    groups_by_misstated_volumes,
    stand_in_for_volume,
)
from avahazard.effects.catalogue import definition
from avahazard.effects.columns import EventColumns, build_columns
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.event import Event
from avahazard.records.path import Path
from tests.criticism.studies import straight

LAW, SCATTER, SEASON, ERROR = "volume-law", "volume-scatter", "season", "volume-error"
FRONT = "leading-edge"


def fit(evidence: float) -> Any:
    return SimpleNamespace(evidence=evidence, specification=Specification(), facts={})


@pytest.mark.parametrize(
    ("leader", "beside", "overstated", "expected"),
    [
        (LAW, 21.0, 20.0, ERROR),
        (LAW, 27.0, 20.0, None),
        (LAW, 27.0, 26.0, ERROR),
        (SCATTER, 21.0, 20.0, ERROR),
        (SEASON, 21.0, 20.0, None),
        (FRONT, 21.0, 20.0, ERROR),
        (FRONT, 24.0, 20.0, None),
        ("covariate:deposit_length_m", 19.0, 20.0, ERROR),
        ("covariate:deposit_length_m", 22.5, 20.0, ERROR),
        ("covariate:deposit_length_m", 24.0, 20.0, None),
        ("covariate:volume_m3", 19.0, 20.0, None),
    ],
)
def test_what_is_of_the_volume_must_earn_its_evidence_beside_its_errors(
    monkeypatch: pytest.MonkeyPatch,
    leader: str,
    beside: float,
    overstated: float,
    expected: str | None,
) -> None:
    """`overstated` is the evidence of the errors where many records are over any true volume."""
    records = straight(20)
    events = (
        replace(e, volume_m3=1e4 * (k + 1), deposit_length_m=30.0 + 5.0 * k)
        for k, e in enumerate(records.events)
    )
    observations = build_observations(replace(records, events=tuple(events)))
    screening: Any = SimpleNamespace(
        candidates=[
            SimpleNamespace(key=k, definition=find_definition(k, ())) for k in (leader, ERROR)
        ]
    )
    base, first = fit(0.0), fit(30.0)

    def refitted(*told: Any) -> Any:
        return fit(beside if told[-1] is first else overstated)

    monkeypatch.setattr(misstated_volumes, "refit", refitted)
    fits = {leader: first, ERROR: fit(20.0)}
    found = by_misstated_volumes(observations, (), base, fits, leader, screening)
    assert found == expected
    stated: Any = SimpleNamespace(candidates=[])
    assert by_misstated_volumes(observations, (), fit(0.0), fits, leader, stated) is None
    base.specification = Specification(effects=(ERROR,))
    assert by_misstated_volumes(observations, (), base, fits, leader, screening) is None


@pytest.mark.parametrize(("left", "expected"), [(2.9, ERROR), (3.1, None)])
def test_groups_must_earn_their_evidence_beside_errors_of_volumes(
    monkeypatch: pytest.MonkeyPatch, left: float, expected: str | None
) -> None:
    """`left` is the evidence of the groups where the errors may be misstated too."""
    observations: Any = None
    candidates = [SimpleNamespace(key=k, definition=definition(k)) for k in (SEASON, ERROR)]
    monkeypatch.setattr(misstated_volumes, "_on_volumes", lambda entry, _: entry.key == ERROR)
    evidence = {("path-effect", ERROR): 30.0 + left, (ERROR,): 30.0}

    def refitted(_observations: Any, specification: Any, *told: Any) -> Any:
        keys = (*specification.effects, *told[1])
        return SimpleNamespace(
            specification=Specification(effects=keys), facts={}, evidence=evidence[keys]
        )

    monkeypatch.setattr(misstated_volumes, "refit", refitted)
    monkeypatch.setattr(verdict, "refit", refitted)
    base: Any = SimpleNamespace(specification=Specification(effects=("path-effect",)), facts={})
    for tried, told in ((candidates, expected), (candidates[:1], None)):
        screening: Any = SimpleNamespace(candidates=tried)
        found = groups_by_misstated_volumes(observations, (), base, "path-effect", screening)
        assert found == told


def test_a_column_stands_in_for_the_volume_where_it_goes_with_it_within_paths() -> None:
    rng = np.random.default_rng(3)
    size = rng.standard_normal(60)
    front = definition(FRONT)

    def columns(noise: float, between: float) -> EventColumns:
        """Lengths that go with volumes as far as `noise` lets them, and `between` paths."""
        away = noise * rng.standard_normal(60)
        events = [
            Event(
                str(k),
                f"P{k % 2}",
                volume_m3=float(np.exp(9.0 + size[k] + between * (k % 2))),
                deposit_length_m=None
                if k < 5
                else float(np.exp(4.0 + 0.3 * size[k] + away[k] + between * (k % 2))),
            )
            for k in range(60)
        ]
        return build_columns(events, {n: Path(n) for n in ("P0", "P1")}, np.full(60, np.nan))

    found = stand_in_for_volume(columns(0.2, 0.0), front)
    assert found is not None
    np.testing.assert_array_equal(np.isfinite(found), np.arange(60) >= 5)
    assert np.nanmean(found) == pytest.approx(4.0, abs=0.3)
    assert stand_in_for_volume(columns(5.0, 0.0), front) is None
    # What differs between paths alone tells nothing of one avalanche.
    assert stand_in_for_volume(columns(5.0, 3.0), front) is None
    for other in (SEASON, LAW, "snow-type"):
        assert stand_in_for_volume(columns(0.2, 0.0), definition(other)) is None
