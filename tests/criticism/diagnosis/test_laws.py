"""Shapes of smooths and the laws that they may be."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis import diagnose, laws
from avahazard.criticism.diagnosis.diagnose import beside_places, leading_smooth
from avahazard.criticism.diagnosis.laws import (
    LEVELS,
    CurvesLikelihood,
    curves_likelihood,
    drawn_roughness,
    found_laws,
    found_shape,
    match,
    matched,
    rougher,
    with_laws,
)
from avahazard.criticism.diagnosis.refits import Refit, refit, refit_with
from avahazard.effects.effect import Curve, FrictionEffect
from avahazard.effects.law_forms import forms_of
from avahazard.effects.own_file import definition_from
from avahazard.inference.likelihood.assemble import find_definition
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.model.specification import Specification
from avahazard.report.model_tables import shape_table
from avahazard.results.base import Rows
from tests.criticism.lengths import lengths, shifted
from tests.effects.event_table import event_table
from tests.results.samples import CANDIDATE, DIAGNOSIS

KEY = "covariate:column_1"


@cache
def fits() -> tuple[Observations, Refit, Refit]:
    """Records whose friction has a step at 0.5 in column 1; the base model, and with a smooth."""
    x = np.random.default_rng(5).standard_normal(150)
    records = shifted(lengths(150, seed=5), {"column_1": x}, 0.4 * (x > 0.5))
    observations = build_observations(records)
    base = refit(observations, Specification(law="power"), {})
    return observations, base, refit_with(base, KEY)


def test_the_band_of_a_polynomial_is_that_of_what_the_effect_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(laws, "ROUGHNESS", (0.0,))
    _, _, fit = fits()
    found = found_shape(fit, KEY)
    assert found is not None
    quantiles = found.q05, found.q50, found.q95
    effect = next(e for e in fit.posterior.effects if e.key == KEY)
    assert isinstance(effect, FrictionEffect)
    table = event_table(column_1=list(found.x))
    slow = []
    for draw in fit.sample:
        values = fit.posterior.layout.effect_values(draw)[KEY]
        at = [sum(c * v for c, v in zip(row, values, strict=True)) for row in effect.design(table)]
        slow.append([height - sum(at) / len(at) for height in at])
    for level, quantile in zip(LEVELS, quantiles, strict=True):
        np.testing.assert_allclose(quantile, np.quantile(slow, level, axis=0), atol=1e-9)
    # The step: below 0 on one side, above on the other, by more than the band is wide.
    low, middle, high = quantiles
    assert np.min(high) < 0.0 < np.max(low)
    assert np.argmin(middle) < np.argmax(middle)


def test_levels_are_against_the_mean_of_the_events() -> None:
    names = np.array(["a", "b", "c"])[np.random.default_rng(5).choice(3, 150, p=[0.5, 0.3, 0.2])]
    true = {"a": 0.0, "b": 0.4, "c": -0.3}
    friction = np.array([true[name] for name in names])
    records = shifted(lengths(150, seed=5), {"weather": names}, friction)
    base = refit(build_observations(records), Specification(law="power"), {})
    found = found_shape(refit_with(base, "covariate:weather"), "covariate:weather")
    assert found is not None
    assert found.levels == ("a", "b", "c")
    assert (found.of, found.value, found.x) == ("weather", "log friction", ())
    for level, low, high in zip(found.levels, found.q05, found.q95, strict=True):
        assert low - 0.03 < true[level] - np.mean(friction) < high + 0.03
    share = [np.mean(names == level) for level in found.levels]
    assert float(np.dot(share, found.q50)) == pytest.approx(0.0, abs=0.02)
    diagnosis = replace(
        DIAGNOSIS,
        candidates=Rows([replace(CANDIDATE, effect="covariate:weather", shape=found)]),
        missing=("covariate:weather",),
    )
    table = shape_table(diagnosis)
    assert table is not None
    assert [row[0] for row in table.rows] == ["b", "a", "c"]


def some_curve(*, rests: bool, n: int = 61) -> Curve:
    """A polynomial of degree 4 over 0 to 30, 0 on average or at 0."""
    t = np.linspace(0.0, 1.0, n)
    columns = np.column_stack([t**k for k in range(1, 5)])
    columns = columns if rests else columns - np.mean(columns, axis=0)
    return Curve("slope", "", "friction", 30.0 * t, columns, rests, "added_friction", "", ())


@pytest.mark.parametrize("rests", [True, False])
def test_a_rougher_curve_is_a_regression_on_many_small_bends(rests: bool) -> None:
    """The integrated Wiener process as the sum of bends at 1,000 places, each normal by itself."""
    rng = np.random.default_rng(3)
    curve, sd, size = some_curve(rests=rests), np.array([0.1, 0.05, 0.05, 0.05]), 0.2
    at = np.linspace(0, 60, 10).round().astype(int)
    half = rng.standard_normal((10, 10))
    precision = 50.0 * half @ half.T
    pull = precision @ rng.normal(0.0, 0.1, 10)
    found = rougher(curve, sd, CurvesLikelihood(curve.x[at], precision, pull), size)
    t, n = curve.x / 30.0, 1000
    bends = np.maximum(t[:, None] - (np.arange(n) + 0.5) / n, 0.0) * size * np.sqrt(3.0 / n)
    columns = np.column_stack([sd * curve.columns, bends])
    columns = columns if rests else columns - np.mean(columns, axis=0)
    inner = np.eye(columns.shape[1]) + columns[at].T @ precision @ columns[at]
    covariance = columns @ np.linalg.solve(inner, columns.T)
    np.testing.assert_allclose(found.covariance, covariance, atol=2e-4 * np.max(covariance))
    slope = columns[at].T @ pull
    mean = columns @ np.linalg.solve(inner, slope)
    np.testing.assert_allclose(found.mean, mean, atol=2e-4 * np.max(np.abs(mean)))
    evidence = 0.5 * slope @ np.linalg.solve(inner, slope) - 0.5 * np.linalg.slogdet(inner)[1]
    assert found.evidence == pytest.approx(float(evidence), abs=0.01)


def test_the_band_holds_a_curve_with_a_kink_as_often_as_it_says() -> None:
    rng = np.random.default_rng(8)
    curve, sd = some_curve(rests=False), np.array([0.1, 0.05, 0.05, 0.05])
    at = np.linspace(0, 60, 10).round().astype(int)
    held = {"polynomial": [], "rougher": []}
    for _ in range(60):
        true = 0.2 * np.maximum(curve.x / 30.0 - rng.uniform(0.2, 0.6), 0.0)
        true -= np.mean(true)
        precision = np.diag(np.full(10, 0.004**-2.0))
        pull = precision @ (true[at] + rng.normal(0.0, 0.004, 10))
        known = CurvesLikelihood(curve.x[at], precision, pull)
        plain = rougher(curve, sd, known, 0.0)
        drawn = rng.multivariate_normal(plain.mean, plain.covariance, 500, method="eigh")
        _, more = drawn_roughness(curve, sd, known, 500, rng)
        for name, curves in (("polynomial", drawn), ("rougher", drawn + more)):
            low, high = np.quantile(curves, [0.05, 0.95], axis=0)
            held[name].append(np.mean((low <= true) & (true <= high)))
    assert np.mean(held["polynomial"]) < 0.8
    assert 0.86 < np.mean(held["rougher"]) < 0.98


def test_draws_have_the_spread_of_the_curvature_at_the_mode() -> None:
    _, _, fit = fits()
    expected = np.sqrt(np.diag(fit.mode.covariance))
    np.testing.assert_allclose(np.std(fit.sample, axis=0), expected, rtol=0.3)


def test_a_form_is_matched_as_by_integration() -> None:
    """The evidence of a form, and its likeliest values, on a fine grid of all its parameters."""
    _, _, fit = fits()
    curve = find_definition(KEY).curve(fit.facts[KEY])
    assert curve is not None
    places, precision, pull = curves_likelihood(fit, KEY, curve, 0.5)
    form = next(form for form in forms_of(curve, 0.5) if form.name == "saturating")
    found = match(form, places, precision, pull)
    (change, length) = form.parameters
    total = []
    for a in np.linspace(-4.0, 4.0, 801) * change.prior_sd:
        for b in np.linspace(length.low, length.high, 25):
            heights = a * form.shape(places, np.array([b]))
            likely = pull @ heights - 0.5 * heights @ precision @ heights
            prior = -0.5 * (a / change.prior_sd) ** 2
            total.append((likely + prior, -0.5 * ((b - length.prior_mean) / length.prior_sd) ** 2))
    both = np.array(total)
    top = np.max(both.sum(axis=1))
    weight = np.exp(both[::1, 1])
    share = weight / np.sum(weight[:25])
    step = 8.0 / 800.0 / np.sqrt(2.0 * np.pi)
    slow = np.log(np.sum(np.exp(both[:, 0] - top) * share) * step) + top
    assert found.evidence == pytest.approx(slow, abs=0.02)


def test_the_law_of_a_step_is_among_the_laws() -> None:
    observations, base, fit = fits()
    laws = found_laws(base, {KEY: fit})[KEY]
    by_name = {law.law.form: law for law in laws}
    assert "step" in by_name
    assert "linear" not in by_name
    assert laws[0].law.evidence - laws[-1].law.evidence < 3.0
    step, text, *_ = by_name["step"]
    change, centre = step.parameters["change"], step.parameters["centre"]
    assert change.q05 < 0.4 < change.q95
    assert centre.q05 < 0.5 < centre.q95
    # It explains more than the curve does, which pays for bends that nobody needs.
    assert step.evidence > fit.evidence - base.evidence
    # What is written is what was fitted.
    entry = definition_from(text, "law.py")
    again = refit(observations, base.specification, base.facts, (entry.key,), (entry,), base)
    drawn = again.drawn(entry.key)[:, 0]
    again = np.quantile(drawn, LEVELS)
    np.testing.assert_allclose(again, [change.q05, change.q50, change.q95], atol=0.02)


def test_the_band_is_that_of_the_curve_or_of_a_law_as_their_evidence_says() -> None:
    _, base, fit = fits()
    first = found_laws(base, {KEY: fit})[KEY][0]
    curve = find_definition(KEY).curve(fit.facts[KEY])
    assert curve is not None
    true = 0.4 * (curve.x > 0.5)
    true -= np.mean(true)

    def band(evidence_over_curve: float) -> tuple[Floats, Floats]:
        law = replace(first.law, evidence_over_curve=evidence_over_curve)
        found = found_shape(fit, KEY, (first._replace(law=law),))
        assert found is not None
        return np.array(found.q05), np.array(found.q95)

    alone = found_shape(fit, KEY)
    assert alone is not None
    np.testing.assert_allclose(band(-1e9), [alone.q05, alone.q95], atol=0.02)
    by_law = np.quantile(first.curves, [0.05, 0.95], axis=0)
    np.testing.assert_allclose(band(1e9), by_law, atol=0.02)
    # A step is no curve of few bends: its law is nearer to it, and knows it better.
    away = np.abs(curve.x - 0.5) > 0.3
    for low, high, share in ((*band(1e9), 0.9), (np.array(alone.q05), np.array(alone.q95), 0.7)):
        assert (np.mean(((low <= true) & (true <= high))[away]) > 0.85) == (share == 0.9)
    assert np.mean(np.subtract(*band(1e9)[::-1])) < np.mean(np.subtract(alone.q95, alone.q05))


def test_the_evidence_of_the_smooth_itself_to_second_order_is_that_of_its_fit() -> None:
    _, base, fit = fits()
    matches, smooth = matched(fit, KEY)
    assert smooth == pytest.approx(fit.evidence - base.evidence, abs=2.0)
    best = max(matches, key=lambda m: m.evidence)
    assert best.form.name == "step"
    assert best.evidence > smooth
    # What is no force by a state of the ground stands by itself.
    assert with_laws(base, {KEY: fit}, {KEY: 12.0}) == ({KEY: 12.0}, {})
    assert with_laws(base, {}, {}) == ({}, {})


def test_a_column_that_matters_beyond_a_limit_leads_over_its_pairs_by_its_law() -> None:
    _, base, fit = fits()
    smooth = fit.evidence - base.evidence
    pair = "interaction:column_1*volume_m3"
    evidence, found = with_laws(base, {KEY: fit, pair: fit}, {KEY: smooth, pair: smooth + 2.0})
    assert found[KEY][0].law.form == "step"
    assert evidence[KEY] == pytest.approx(smooth + found[KEY][0].law.evidence_over_curve)
    assert evidence[KEY] > evidence[pair] == smooth + 2.0


def test_a_model_may_get_a_second_law_of_one_form() -> None:
    """What a law of a band leaves over may be a band again."""
    _, base, fit = fits()
    first = found_laws(base, {KEY: fit})[KEY][0]
    own = [definition_from(first.text, "first.py")]
    given = fit.observations, base.specification, base.facts
    with_first = refit(*given, (first.law.effect,), own)
    again = refit_with(with_first, KEY)
    keys = [m.form.key for m in matched(again, KEY)[0]]
    assert first.law.effect not in keys
    assert f"{first.law.effect}-2" in keys
    second = found_laws(with_first, {KEY: again})[KEY]
    assert all(np.isfinite(law.law.evidence) for law in second)


def test_laws_are_asked_of_what_leads_alone() -> None:
    _, _, fit = fits()
    assert leading_smooth((KEY,), {KEY: fit}) == KEY
    assert leading_smooth((), {KEY: fit}) is None
    assert leading_smooth(("path-effect", KEY), {KEY: fit}) is None


@pytest.mark.parametrize(
    ("by_law", "leads"),
    [(365.0, "force:elevation"), (60.0, "force:distance")],
    ids=["band", "bend"],
)
def test_a_law_of_the_ground_is_held_against_stretches_of_paths(
    monkeypatch: pytest.MonkeyPatch, by_law: float, leads: str
) -> None:
    """Stretches may follow a band of elevation on several paths, which its law has at once."""
    forms = {"force:distance": "", "force:elevation": "added_friction", "force:slope": "other"}
    monkeypatch.setattr(laws, "curve_of", lambda _, key: SimpleNamespace(form=forms[key]))
    monkeypatch.setattr(laws, "_law_gain", lambda *_: 20.0)
    law = SimpleNamespace(evidence_over_curve=by_law - 55.0)
    fitted = (SimpleNamespace(law=law),)
    monkeypatch.setattr(laws, "found_laws", lambda _, of: dict.fromkeys(of, fitted))
    found = {"force:distance": 138.0, "force:elevation": 55.0, "force:slope": 10.0}
    fits: Any = {key: SimpleNamespace(evidence=value) for key, value in found.items()}
    base: Any = SimpleNamespace(evidence=0.0)
    evidence, fitted_laws = with_laws(base, fits, found)
    assert max(evidence, key=lambda key: evidence[key]) == leads
    assert evidence["force:elevation"] == max(by_law, 55.0)
    assert evidence["force:slope"] == 10.0
    assert fitted_laws == {"force:elevation": fitted}
    # What is no force by the place has no rivals there.
    assert with_laws(base, fits, found | {"force:slope": 200.0})[1] == {}


@pytest.mark.parametrize(("of_law", "left"), [(250.0, 295.0), (-4.0, -4.0)], ids=["band", "speeds"])
def test_a_law_that_leads_is_itself_held_against_friction_by_place(
    monkeypatch: pytest.MonkeyPatch, of_law: float, left: float
) -> None:
    """The smooth of a narrow band follows it so badly that it has no evidence of its own."""
    smooth: Any = SimpleNamespace()
    law: Any = SimpleNamespace(fit=smooth, law=SimpleNamespace(effect="law"))
    beside = {"force:elevation": -6.0, "law": of_law}
    monkeypatch.setattr(diagnose, "evidence_beside_places", lambda _, key: beside[key])
    found = {"force:elevation": 295.0}
    fits = {"force:elevation": smooth}
    assert beside_places(found, fits, {"force:elevation": (law,)}) == {"force:elevation": left}
    assert beside_places(found, fits) == {"force:elevation": -6.0}
