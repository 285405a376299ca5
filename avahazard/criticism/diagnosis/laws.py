"""The shape of a smooth that was found, and the laws that it may be.

The band is that of a curve that may be rougher than the polynomial fitted: a Wiener process
integrated once, averaged over its size by evidence (Wahba 1978), and laws. Forms are screened by
the scores of the curve's heights, then fitted as the effect files that they are
(docs/theory/criticism.md, "Shape and laws").
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit, peak_with, refit
from avahazard.criticism.screening.linear_model import linear_model
from avahazard.effects.covariate import PREFIX, VOLUME, in_logs, level_counts, text_column
from avahazard.effects.effect import Curve
from avahazard.effects.law_forms import LawForm, forms_of, free_curve
from avahazard.effects.own_file import definition_from
from avahazard.effects.pairs import columns_of_pair
from avahazard.engine import spread_map
from avahazard.inference.seeds import generator
from avahazard.results.diagnosis import FittedLaw, LawParameter, Shape

LEVELS = (0.05, 0.5, 0.95)
PLACES, POINTS = 10, 25
"""Places of curves, and values of each parameter of a form's shape on the grid."""
FITTED, NEAR, NEAR_SHARE = 4, 6.0, 0.03
"""Forms that are fitted at most, and how near to the best of the screening they must be: nats, or
a share of what the smooth gains, where the second order is no more exact."""
ROUGHNESS = (0.0, 0.3, 1.0, 3.0)
"""Sizes of what a curve may have beyond its polynomial, in prior sd of its line."""
RIVAL_SHARE = 0.65
"""Share of the best evidence that a state of the ground may lack before its laws are fitted."""


class FoundLaw(NamedTuple):
    """A law that a smooth may be, the text of its effect file, and the model with it.

    `curves` `[n_draws, n_x]` are draws of its curve.
    """

    law: FittedLaw
    text: str
    fit: Refit
    curves: Floats


Laws = tuple[FoundLaw, ...]
"""Laws that a smooth may be, the best first."""


def found_shape(fit: Refit, key: str, laws: Laws = ()) -> Shape | None:
    """The curve of smooth `key` of a fit, or its levels, by the posterior; None for what has none.

    It may be any of its `laws` as well, each as probable as its evidence says.
    """
    curve = curve_of(fit, key)
    if curve is None:
        return _found_levels(fit, key)
    curves = fit.drawn(key) @ curve.columns.T
    if curve.form:
        sd, _, known = likelihood_of_smooth(fit, key, curve)
        rng = generator(0, f"band of {key}")
        evidence, beyond = drawn_roughness(curve, sd, known, len(curves), rng)
        log_z = np.array([evidence, *(found.law.evidence_over_curve for found in laws)])
        chosen = rng.choice(len(log_z), len(curves), p=np.exp(log_z - logsumexp(log_z)))
        curves = curves + beyond
        for k, found in enumerate(laws, 1):
            rows = rng.integers(len(found.curves), size=np.sum(chosen == k))
            curves[chosen == k] = found.curves[rows]
    low, middle, high = (tuple(row) for row in np.quantile(curves, LEVELS, axis=0).tolist())
    unit = "m3" if curve.of == VOLUME else curve.unit
    places = tuple((np.exp(curve.x) if in_logs(curve.of) else curve.x).tolist())
    return Shape(curve.of, unit, curve.value, places, low, middle, high, curve.path)


def _found_levels(fit: Refit, key: str) -> Shape | None:
    """Log friction at each level of a column of texts, 0 on average of the events that have one."""
    facts, column = fit.facts.get(key, {}), fit.definition(key).column
    if column is None or "reference" not in facts:
        return None
    levels = (facts["reference"], *facts["levels"])
    texts = text_column(fit.observations.columns, column)
    assert texts is not None
    count, drawn = level_counts(texts), fit.drawn(key)
    drawn = np.column_stack([np.zeros(len(drawn)), drawn])
    drawn -= np.average(drawn, axis=1, weights=[count[level] for level in levels])[:, None]
    low, middle, high = (tuple(row) for row in np.quantile(drawn, LEVELS, axis=0).tolist())
    return Shape(column, "", "log friction", (), low, middle, high, levels=levels)


def drawn_roughness(
    curve: Curve, sd: Floats, known: CurvesLikelihood, n: int, rng: np.random.Generator
) -> tuple[float, Floats]:
    """Evidence (nats) for a curve beyond its polynomial, and draws `[n, n_x]` of what it has there.

    The polynomial has prior `sd` `[n_parameters]`.
    """
    fits = [rougher(curve, sd, known, size * float(sd[0])) for size in ROUGHNESS]
    log_z = np.array([found.evidence for found in fits])
    chosen = rng.choice(len(fits), n, p=np.exp(log_z - logsumexp(log_z)))
    unit = rng.standard_normal((n, len(curve.x)))
    drawn = np.empty_like(unit)
    for k, found in enumerate(fits):
        # What the polynomial leaves open already, its draws have.
        value, vector = np.linalg.eigh(found.covariance - fits[0].covariance)
        root = vector * np.sqrt(np.maximum(value, 0.0))
        drawn[chosen == k] = found.mean - fits[0].mean + unit[chosen == k] @ root.T
    return float(logsumexp(log_z) - np.log(len(fits)) - log_z[0]), drawn


class RougherCurve(NamedTuple):
    """A curve given its likelihood: evidence (nats), mean `[n_x]`, covariance `[n_x, n_x]`."""

    evidence: float
    mean: Floats
    covariance: Floats


def rougher(curve: Curve, sd: Floats, known: CurvesLikelihood, size: float) -> RougherCurve:
    """A polynomial plus an integrated Wiener process, which spreads by `size` up to the high end.

    A normal prior of the heights; see (Rasmussen and Williams 2006, section 6.3).
    """
    at = np.searchsorted(curve.x, known.places)
    columns, t = sd * curve.columns, (curve.x - curve.x[0]) / np.ptp(curve.x)
    least, most = np.minimum.outer(t, t), np.maximum.outer(t, t)
    prior = columns @ columns.T + size**2 * 0.5 * least**2 * (3.0 * most - least)
    if not curve.rests:
        prior -= prior.mean(axis=0)
        prior -= prior.mean(axis=1)[:, None]
    seen = prior[:, at]
    both = np.eye(len(at)) + known.precision @ seen[at]
    pull = np.linalg.solve(both, known.pull)
    evidence = 0.5 * known.pull @ seen[at] @ pull - 0.5 * np.linalg.slogdet(both)[1]
    covariance = prior - seen @ np.linalg.solve(both, known.precision @ seen.T)
    return RougherCurve(float(evidence), seen @ pull, covariance)


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """A form set against curves: its evidence to second order, up to a constant (nats).

    `shapes` `[n, n_shape]` have each its `share` of probability; at `begin` `[n_parameters]` the
    form is likeliest; `spread_out` is the evidence less that with the likeliest shape alone.
    """

    form: LawForm
    evidence: float
    shapes: Floats
    share: Floats
    begin: Floats
    spread_out: float


def found_laws(base: Refit, fits: Mapping[str, Refit]) -> dict[str, Laws]:
    """The laws that each smooth may be, of `fits` of the model `base` with it by key; best first.

    Those within `MARGIN` of the best. None of a smooth whose laws all fall short by `NEAR` of those
    of another.
    """
    asked = [(key, match) for key, fit in fits.items() for match in _near(base, fit, key)]
    if all(match.form.curve.form != "friction" for _, match in asked):
        # A rough mode costs a fifth of a fit: what falls short by far is not fitted.
        ascents = list(spread_map(_ascended, (base, fits), asked))
        top = max((reached for reached, _ in ascents), default=0.0)
        pairs = zip(asked, ascents, strict=True)
        asked = [
            (k, replace(m, begin=at)) for (k, m), (reached, at) in pairs if reached > top - NEAR
        ]
    fitted = list(spread_map(_fitted, (base, fits), asked))
    found: dict[str, Laws] = {}
    for key in fits:
        laws = [x for (k, _), x in zip(asked, fitted, strict=True) if k == key]
        laws.sort(key=lambda x: -x.law.evidence)
        found[key] = tuple(x for x in laws if x.law.evidence > laws[0].law.evidence - MARGIN)
    return found


def _near(base: Refit, fit: Refit, key: str) -> list[Match]:
    """The forms that stand beside the best, to second order; the best first."""
    matches, _ = matched(fit, key)
    reach = max(NEAR, NEAR_SHARE * (fit.log_likelihood - base.log_likelihood))
    return [m for m in matches if m.evidence > matches[0].evidence - reach][:FITTED]


def curve_of(fit: Refit, key: str) -> Curve | None:
    """The curve of smooth `key` of a fit; None for what is no curve."""
    return fit.definition(key).curve(fit.facts.get(key, {}))


def matched(fit: Refit, key: str) -> tuple[list[Match], float]:
    """How the forms match the curve of smooth `key`, best first, and the evidence of the smooth."""
    curve = curve_of(fit, key)
    assert curve is not None
    sd, spread, known = likelihood_of_smooth(fit, key, curve)
    smooth = rougher(curve, sd, known, 0.0).evidence
    forms = forms_of(curve, spread, fit.specification.effects)
    matches = [match(form, *known) for form in forms]
    return sorted(matches, key=lambda m: -m.evidence), smooth


def likelihood_of_smooth(
    fit: Refit, key: str, curve: Curve
) -> tuple[Floats, float, CurvesLikelihood]:
    """Of smooth `key` the prior sd of its parameters, of its ends, and its `curves_likelihood`."""
    effect = next(e for e in fit.posterior.effects if e.key == key)
    sd = np.array([p.prior_sd for p in effect.parameters])
    spread = abs(float(np.ptp(curve.columns[[0, -1], 0]))) * float(sd[0])
    known = fit.kept.get(f"curves of {key}") or curves_likelihood(fit, key, curve, spread)
    fit.kept[f"curves of {key}"] = known
    return sd, spread, known


def with_laws(
    base: Refit, fits: Mapping[str, Refit], evidence: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, Laws]]:
    """Evidence (nats) of candidates; where a force by the ground leads, that of states with laws.

    What the best law adds to its smooth distinguishes states that are alike along a path. It is
    taken to second order; of states that may lead, whose laws are returned, from their fits. So are
    laws of the columns of a pair that leads: beyond a limit of one no smooth goes as sharply.
    """
    leader = max(evidence, key=lambda key: evidence[key], default=None)
    if leader is not None and (names := columns_of_pair(leader)):
        smooths = [key for name in names if (key := PREFIX + name) in evidence]
        curved = [key for key in smooths if (c := curve_of(fits[key], key)) and c.form]
        return _with_laws_of(base, fits, evidence, curved)
    if leader is None or form_by_place(curve_of(fits[leader], leader)) is None:
        return dict(evidence), {}
    places = [key for key in evidence if form_by_place(curve_of(fits[key], key)) is not None]
    states = [key for key in places if form_by_place(curve_of(fits[key], key))]
    found = dict(evidence) | {key: evidence[key] + _law_gain(fits[key], key) for key in states}
    top = max(found[key] for key in places)
    close = [key for key in states if found[key] > top - max(NEAR, RIVAL_SHARE * top)]
    if top <= MARGIN:
        return found, {}
    more, laws = _with_laws_of(base, fits, evidence, close)
    return found | {key: more[key] for key in close}, laws


def _with_laws_of(
    base: Refit, fits: Mapping[str, Refit], evidence: Mapping[str, float], keys: Sequence[str]
) -> tuple[dict[str, float], dict[str, Laws]]:
    """The evidence with what the best laws of these smooths add, and their laws."""
    laws = found_laws(base, {key: fits[key] for key in keys})
    gains = {k: max([0.0, *(one.law.evidence_over_curve for one in laws[k][:1])]) for k in keys}
    return {key: nats + gains.get(key, 0.0) for key, nats in evidence.items()}, laws


def form_by_place(curve: Curve | None) -> str | None:
    """The form of a force by the place, empty for stretches of paths; None for all else."""
    return curve.form if curve is not None and curve.form in ("added_friction", "") else None


def _law_gain(fit: Refit, key: str) -> float:
    matches, smooth = matched(fit, key)
    return max(0.0, matches[0].evidence - smooth)


class CurvesLikelihood(NamedTuple):
    """Normal likelihood of heights at `places` `[n]`; `pull` is the precision times the mean."""

    places: Floats
    precision: Floats
    pull: Floats


def curves_likelihood(fit: Refit, key: str, curve: Curve, spread: float) -> CurvesLikelihood:
    """That of curves of size `spread` in the place of smooth `key`; all else is projected out."""
    model = linear_model(fit.posterior, fit.mode.u)
    effect = fit.posterior.effects[-1]
    assert effect.key == key
    at = np.linspace(0, len(curve.x) - 1, PLACES).round().astype(np.int64)
    places = curve.x[at]
    free = definition_from(free_curve(curve, places, spread), "curve").build({})
    columns = model.of_effect(free, free.neutral)
    weighed = model.projected(columns, but_last=len(effect.parameters))
    bend = weighed.T @ columns
    at_mode = fit.posterior.layout.effect_values(fit.mode.u)[key] @ curve.columns.T
    return CurvesLikelihood(places, bend, weighed.T @ model.residual + bend @ at_mode[at])


def match(form: LawForm, places: Floats, precision: Floats, pull: Floats) -> Match:
    """A form against a normal likelihood of a curve's heights; the change is integrated over."""
    change, *shape = form.parameters
    axes = [np.linspace(p.low, p.high, POINTS) for p in shape]
    shapes = np.array(list(product(*axes)))
    heights = np.array([form.shape(places, values) for values in shapes]).T
    bend = np.sum(heights * (precision @ heights), axis=0) + change.prior_sd**-2.0
    slope = pull @ heights
    gain = 0.5 * slope**2 / bend - 0.5 * np.log(bend * change.prior_sd**2)
    means, sds = (np.array([getattr(p, e) for p in shape]) for e in ("prior_mean", "prior_sd"))
    prior = -0.5 * np.sum(((shapes - means) / sds) ** 2, axis=1)
    whole = gain + prior - logsumexp(prior)
    total, top = float(logsumexp(whole)), int(np.argmax(whole))
    likely = np.clip(slope[top] / bend[top], 0.98 * change.low, 0.98 * change.high)
    begin = np.array([likely, *shapes[top]])
    return Match(form, total, shapes, np.exp(whole - total), begin, total - float(gain[top]))


Shared = tuple[Refit, Mapping[str, Refit]]
"""The model without the smooths, and with each."""


def _ascended(shared: Shared, asked: tuple[str, Match]) -> tuple[float, Floats]:
    """The log density at the mode of a form, roughly, and its parameters there."""
    (base, fits), (key, found) = shared, asked
    entry = definition_from(_text(found, base.definition(key).meaning), f"{found.form.key}.py")
    return peak_with(base, entry, fits[key], _inside(found))


def _fitted(shared: Shared, asked: tuple[str, Match]) -> FoundLaw:
    """A form fitted to the records from where it fits the curve.

    Where the effect file fixes the shape, the evidence is that of all shapes by the curve.
    """
    (base, fits), (key, found) = shared, asked
    form, inside, text = found.form, _inside(found), _text(found, base.definition(key).meaning)
    entry = definition_from(text, f"{form.key}.py")
    fixed = form.curve.form == "friction"
    begin = inside[:1] if fixed else inside
    given, own = (base.observations, base.specification, base.facts), (*base.own, entry)
    fit = refit(*given, (form.key,), own, start=fits[key], begin=begin)
    drawn = fit.drawn(form.key)
    evidence = fit.evidence - base.evidence
    if fixed:
        rng = generator(0, f"shape of {form.key}")
        shapes = found.shapes[rng.choice(len(found.shapes), len(drawn), p=found.share)]
        # Within a cell of the grid any shape is as likely as another.
        shapes += rng.uniform(-0.5, 0.5, shapes.shape) * np.ptp(found.shapes, axis=0) / (POINTS - 1)
        ends = np.array([(p.low, p.high) for p in form.parameters[1:]]).reshape(-1, 2).T
        drawn = np.column_stack([drawn, np.clip(shapes, *ends)])
        evidence += found.spread_out
    curves = np.array([row[0] * form.shape(form.curve.x, row[1:]) for row in drawn])
    if not form.curve.rests:
        curves -= np.mean(curves, axis=1, keepdims=True)
    quantiles = np.quantile(drawn, LEVELS, axis=0).T.tolist()
    parameters = {
        p.name: LawParameter(low, middle, high, p.unit)
        for p, (low, middle, high) in zip(form.parameters, quantiles, strict=True)
    }
    over_curve = evidence - (fits[key].evidence - base.evidence)
    law = FittedLaw(form.name, form.key, form.formula, parameters, evidence, over_curve)
    return FoundLaw(law, text, fit, curves)


def _inside(found: Match) -> Floats:
    """Where a form begins, off the ends of its ranges."""
    inside = found.begin.copy()
    for k, p in enumerate(found.form.parameters[1:], 1):
        margin = 0.02 * (p.high - p.low)
        inside[k] = np.clip(inside[k], p.low + margin, p.high - margin)
    return inside


def _text(found: Match, meaning: str) -> str:
    """The effect file of a form, which means what the smooth does, by the formula."""
    form, what = found.form, re.split(r",|\. ", meaning, maxsplit=1)[0].rstrip(".")
    meaning = f"{what}: {form.formula}, s being {form.curve.of}."
    return form.text(meaning, found.begin[1:])
