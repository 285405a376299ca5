"""What a diagnosis found, as it is stored and told: verdict, candidates, what to measure next."""

from __future__ import annotations

from collections.abc import Iterator

from avahazard.criticism.diagnosis.diagnose import error_of
from avahazard.criticism.diagnosis.findings import Candidate as Tried
from avahazard.criticism.diagnosis.findings import Diagnosis as Findings
from avahazard.criticism.diagnosis.force_witness import ForceWitness
from avahazard.criticism.diagnosis.measurements import measurement_gains
from avahazard.criticism.diagnosis.nuisances import MOST_CROSSED
from avahazard.criticism.diagnosis.together import Together
from avahazard.message import message
from avahazard.results.amounts import amount
from avahazard.results.base import Rows
from avahazard.results.diagnosis import (
    Candidate,
    Diagnosis,
    GroupTest,
    MeasuredAmount,
    Measurement,
    Pair,
)
from avahazard.workflow.compare import coordinate_name

MORE_EVENTS = message("{n} more events: effects of {size} show")


def diagnosis(name: str, found: Findings, seed: int) -> Diagnosis:
    """What was found on the model `name`, and what to measure next."""
    return Diagnosis(
        model=name,
        verdict=found.verdict,
        missing=found.missing,
        candidates=Rows(_candidate(c, found) for c in found.candidates),
        groups=Rows(_groups(found)),
        pairs=Rows(_pair(more) for more in found.together),
        detectable_m=found.detectable.metres,
        detectable_log_friction=found.detectable.log_friction,
        detectable_share=found.detectable.share,
        measure_next=_measure_next(found, seed),
        still_needed=found.still_needed,
        heavy_tails=found.heavy_tails,
        suspect_events=found.suspects,
        impossible_stops=found.impossible_stops,
        notes=(
            *(_not_granted(key) for key in found.not_granted),
            *(f"{key} was not asked about: {lack}." for key, lack in found.not_asked.items()),
        ),
        n_worlds=found.screening.n_worlds,
        seed=seed,
        coordinate=coordinate_name(found.base.posterior.observations),
    )


def _not_granted(key: str) -> str:
    return (
        f"{key} was not asked about: these records have too many groups (over {MOST_CROSSED} "
        "crossed with others) to fit together. Add it to the model to see what it does."
    )


def _groups(found: Findings) -> Iterator[GroupTest]:
    layout = found.base.posterior.layout
    spreads = layout.spread_values(found.base.mode.u)
    for test, spread in zip(found.screening.groups, spreads, strict=True):
        yield GroupTest(test.key, test.gain, test.p_value, float(spread))


def _pair(more: Together) -> Pair:
    return Pair(
        effects=more.effects,
        gain=more.gain,
        gain_over_best_single=more.gain_over_best_single,
        p_value=more.p_value,
        error_after_m=error_of(more.fit),
        parameters={k: v for key in more.effects for k, v in more.fit.parameters(key).items()},
    )


def _candidate(candidate: Tried, found: Findings) -> Candidate:
    fit = candidate.fit
    gain = candidate.screened.gain
    if fit is not None:
        gain = fit.log_likelihood - found.base.log_likelihood
    return Candidate(
        effect=candidate.key,
        gain=gain,
        evidence_gain=candidate.evidence_gain,
        held_out_gain=candidate.held_out_gain,
        p_value=candidate.screened.p_family,
        screened_gain=candidate.screened.gain,
        chance_gain=candidate.screened.null_gain,
        p_value_alone=candidate.screened.p_single,
        error_before_m=found.error_before_m,
        error_after_m=candidate.error_after_m,
        parameters={} if fit is None else fit.parameters(candidate.key),
        physics=candidate.screened.definition.meaning,
        confounded_with=candidate.confounded_with,
        force_witness=_amount(candidate.force_witness),
    )


def _amount(witness: ForceWitness | None) -> MeasuredAmount | None:
    return None if witness is None else MeasuredAmount(witness.value, witness.se)


def _measure_next(found: Findings, seed: int) -> Rows[Measurement]:
    """What would part the two best explanations, or show an effect that is too small to see."""
    fits = [c.fit for c in found.candidates if c.fit is not None]
    if len(fits) > 1:
        return measurement_gains(fits[0], fits[1], seed)
    if fits:
        return measurement_gains(fits[0], found.base, seed)
    # An effect as large as the smallest detectable gains in proportion to the events.
    n = found.base.posterior.observations.n_events
    half = amount(
        found.detectable.metres / 2**0.5, coordinate_name(found.base.posterior.observations), 0
    )
    text = MORE_EVENTS.format(n=n, size=half)
    return Rows([Measurement(text, found.screening.critical_gain)])
