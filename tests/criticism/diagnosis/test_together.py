from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.criticism.diagnosis import diagnose as module
from avahazard.criticism.diagnosis.diagnose import (
    Findings,
    diagnose,
    needed_beside,
    product_evidence,
)
from avahazard.criticism.diagnosis.refits import Question
from avahazard.effects.own_file import definition_from
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.report.sentences import verdict_text
from tests.criticism.lengths import lengths, shifted

OWN = """
from avahazard.effects.effect import Parameter
KEY = "by-{0}"
MEANING = "Friction rises with {0}."
NEEDS = ["{0}"]
PARAMETERS = [Parameter("slope", "", 0.0, 0.0, 0.3)]
def friction(columns):
    return [columns.numbers["{0}"]]
"""
COLD, WIND = (definition_from(OWN.format(name), f"{name}.py") for name in ("cold", "wind"))


def diagnosed(cold: float, wind: float, together: float, seed: int, n: int = 90) -> Findings:
    """Friction that follows two columns, whose correlation is `together`."""
    # Other numbers than those of the volumes.
    rng = np.random.default_rng(seed + 100)
    first = rng.standard_normal(n)
    second = together * first + np.sqrt(1.0 - together**2) * rng.standard_normal(n)
    columns = {"cold": first, "wind": second}
    records = shifted(lengths(n, 0.0, seed), columns, cold * first + wind * second)
    return diagnose(build_observations(records), Specification(law="power"), {}, (COLD, WIND))


@pytest.mark.slow
def test_effects_of_a_set_that_are_both_needed_are_distinguished() -> None:
    found = diagnosed(0.13, 0.11, 0.6, seed=1)
    assert found.result.missing == ("by-cold",)
    (more,) = found.result.pairs
    assert more.effects == ("by-cold", "by-wind")
    alone = found.fits["by-cold"]
    taken = alone.parameters("by-cold")["by-cold.slope"]
    # What the first took from the second is given back.
    given_back = more.parameters["by-cold.slope"]
    assert taken > 0.13 + 0.03
    assert abs(given_back - 0.13) < 0.04
    assert more.gain > more.gain_over_best_single > 3.0
    told = found.result
    assert told.pairs[0].effects == ("by-cold", "by-wind")
    assert told.pairs[0].parameters["by-cold.slope"] == given_back
    assert told.pairs[0].error_after_m < told.candidates[0].error_before_m
    assert "by-cold and by-wind" in verdict_text(told)


def test_two_that_hide_each_other_are_named_together() -> None:
    found = diagnosed(0.3, -0.3, 0.95, seed=2)
    assert found.result.verdict == "missing-effect"
    (more,) = found.result.pairs
    assert set(more.effects) == {"by-cold", "by-wind"}
    assert found.result.missing == more.effects[:1]
    alone = [c.p_value for c in found.result.candidates if c.effect in more.effects]
    assert min(alone) > 0.03
    assert more.gain_over_best_single > 8.0
    assert abs(more.parameters["by-cold.slope"] - 0.3) < 0.12
    assert abs(more.parameters["by-wind.slope"] + 0.3) < 0.12


@pytest.mark.slow
def test_one_effect_has_no_second_and_none_has_no_pair() -> None:
    one = diagnosed(0.15, 0.0, 0.6, seed=3)
    assert one.result.missing == ("by-cold",)
    assert not one.result.pairs
    none = diagnosed(0.0, 0.0, 0.9, seed=4)
    assert none.result.verdict == "adequate"
    assert not none.result.pairs


@pytest.mark.parametrize(("each", "product"), [(0.13, 0.0), (0.0, 0.2)])
def test_a_pair_without_a_product_is_two_columns(each: float, product: float) -> None:
    rng = np.random.default_rng(106)
    cold, wind = rng.standard_normal((2, 90))
    change = each * (cold - wind) + product * cold * wind
    records = shifted(lengths(90, 0.0, 6), {"cold": cold, "wind": wind}, change)
    found = diagnose(build_observations(records), Specification(law="power"), {})
    pair = "interaction:cold*wind"
    if product:
        assert found.result.missing == (pair,)
        assert not found.result.pairs
        assert product_evidence(found.fits[pair], pair) > 10.0
    else:
        (two,) = found.result.pairs
        assert set(two.effects) == {"covariate:cold", "covariate:wind"}
        assert found.result.missing == two.effects[:1]


EVIDENCE = {
    (): 0.0,
    ("cold",): 20.0,
    ("wind",): 18.0,
    ("sun",): 25.0,
    ("cold", "wind"): 30.0,
    ("cold", "sun"): 27.0,
    ("cold", "wind", "sun"): 31.0,
}


def fitted(*keys: str) -> Any:
    gain = EVIDENCE[keys]
    return SimpleNamespace(keys=keys, evidence=gain, log_likelihood=gain, parameters=lambda _: {})


@pytest.mark.parametrize(
    ("keys", "needed"),
    [
        (("cold", "wind"), True),
        (("cold", "sun"), False),  # it does alone what both do
        (("cold", "wind", "sun"), False),  # it adds too little
    ],
)
def test_a_set_is_distinguished_where_each_is_needed(
    monkeypatch: pytest.MonkeyPatch, keys: tuple[str, ...], needed: bool
) -> None:
    monkeypatch.setattr(module, "refit_with", lambda fit, key: fitted(*fit.keys, key))
    monkeypatch.setattr(module, "error_of", lambda _fit: 0.0)
    monkeypatch.setattr(
        module, "_is_needed", lambda fit, wider, _more: wider.evidence > fit.evidence + 3.0
    )
    screening: Any = SimpleNamespace(candidates=[SimpleNamespace(key="cold", p_family=0.01)])
    found = needed_beside(Question(fitted(), {"cold": fitted("cold")}, screening), keys)
    assert (None if found is None else found.effects) == (keys if needed else None)
