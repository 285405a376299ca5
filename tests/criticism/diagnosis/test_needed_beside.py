"""What is needed beside a name is what nothing else explains."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from avahazard.criticism.diagnosis import other_readings, together
from avahazard.criticism.diagnosis.other_readings import read_otherwise
from avahazard.criticism.diagnosis.together import needed_beside

EVIDENCE = {
    (): 0.0,
    ("snow-type",): 20.0,
    ("volume-scatter",): 6.0,
    ("season",): 5.0,
    ("snow-type", "volume-scatter"): 30.0,
    ("snow-type", "season"): 26.0,
}


def fitted(*keys: str) -> Any:
    return SimpleNamespace(keys=keys, evidence=EVIDENCE.get(keys, 0.0), log_likelihood=0.0)


@pytest.mark.parametrize(
    ("otherwise", "expected"),
    [((), "volume-scatter"), (("volume-scatter",), "season"), (("volume-scatter", "season"), None)],
)
def test_one_that_errors_may_explain_is_not_needed(
    monkeypatch: pytest.MonkeyPatch, otherwise: tuple[str, ...], expected: str | None
) -> None:
    """`otherwise` are those that misstated errors or stops unseen explain as well."""
    rivals = ("volume-scatter", "season")
    monkeypatch.setattr(
        together, "without_groups", lambda *_: (SimpleNamespace(specification=0),) * 3
    )
    monkeypatch.setattr(together, "candidate_definitions", lambda *_: ())
    monkeypatch.setattr(together, "gains_beside", lambda *_: dict.fromkeys(rivals, 9.0))
    monkeypatch.setattr(
        together, "refit_each", lambda _o, keys, _own, fit: {k: fitted(*fit.keys, k) for k in keys}
    )
    monkeypatch.setattr(together, "_with", lambda _o, _own, _base, keys: fitted(*keys))
    monkeypatch.setattr(
        together, "_is_needed", lambda _own, fit, wider, _more: wider.evidence > fit.evidence + 3.0
    )
    monkeypatch.setattr(
        together, "read_otherwise", lambda *told: ("volume-error",) if told[4] in otherwise else ()
    )
    screening: Any = SimpleNamespace(chance=SimpleNamespace(family_wise=lambda _key, _gain: 0.01))
    observations: Any = None
    fits = {"snow-type": fitted("snow-type")}
    found = needed_beside(observations, (), fitted(), fits, "snow-type", screening)
    assert [more.effects for more in found] == ([("snow-type", expected)] if expected else [])


def test_every_other_reading_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    readings = (lambda *_: "observation-limit", lambda *_: None, lambda *_: "volume-error")
    monkeypatch.setattr(other_readings, "READINGS", readings)
    nothing: Any = None
    told = read_otherwise(nothing, (), nothing, {}, "cohesion", nothing)
    assert told == ("observation-limit", "volume-error")
