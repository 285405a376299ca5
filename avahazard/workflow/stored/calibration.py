"""What a calibration found, summed up."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.nuisances import (
    HEAVY_TAILS,
    WORTH_A_NOTE,
    heavier_tails,
    paths_differ,
)
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.notes import Note
from avahazard.records.collection import Records
from avahazard.records.fingerprint import data_fingerprint
from avahazard.results.calibration import (
    Calibration,
    Convergence,
    GivenTold,
    HeavierTails,
    ParameterSummary,
    PathSpread,
    PriorCoordinate,
    PriorDominated,
    PriorTold,
)
from avahazard.workflow.stored.notes import prior_notes, record_notes, volume_notes

KDE_DRAWS, KDE_POINTS = 4000, 401
NARROWEST = 1e-9
"""Width of the middle half of draws, over their sd, below which it counts as one value."""
STILL_PRIOR = 0.75
"""Posterior over prior standard deviation where the records tell less than the prior (with
independent normals they tell as much at 0.71)."""


def calibration_result(
    found: FittedModel, name: str, records: Records, *, seed: int, parent: str | None = None
) -> Calibration:
    """Sum up what was found of a model on `records`: its parameters, convergence, with notes."""
    specification, chains = found.specification, found.chains
    n_chains, n_draws = chains.draws.shape[:2]
    checks = chains.diagnostics
    rhat_max = float(checks.rhat_max) if np.isfinite(checks.rhat_max) else None
    notes = list(found.notes)
    if not checks.converged:
        ess = min(checks.ess_bulk_min, checks.ess_tail_min)
        notes.append(Note("not_converged", rhat=rhat_max, ess=ess))
    dominated = prior_dominated(found)
    given, prior = _given_told(found), _prior_told(found)
    notes += prior_notes(name, given, prior, dominated)
    of_records = (
        *record_notes(records, found.observations.sites),
        *volume_notes(found, name),
    )
    notes += of_records
    spread = _path_spread(found)
    tails = _heavier_tails(found)
    notes[:0] = [told.note(name) for told in (spread, tails) if told is not None]
    return Calibration(
        model=name,
        parent=parent,
        law=specification.law,
        scatter=specification.scatter,
        distribution=specification.distribution,
        tails=specification.tails,
        centrifugal=specification.centrifugal,
        method=found.method,
        effects=specification.effects,
        n_events=found.n_events,
        left_out=dict(found.left_out),
        parameters={key: summary(draws, unit) for key, draws, unit in _all_draws(found)},
        diagnostics=Convergence(
            rhat_max=rhat_max,
            ess_bulk_min=checks.ess_bulk_min,
            ess_tail_min=checks.ess_tail_min,
            acceptance=checks.acceptance,
            divergent_or_stuck_chains=checks.stuck_chains,
            converged=checks.converged,
        ),
        chains=n_chains,
        draws=n_draws,
        seed=seed,
        data_fingerprint=data_fingerprint(records),
        notes=tuple(notes),
        path_spread=spread,
        heavier_tails=tails,
        prior_dominated=dominated or None,
        of_records=of_records or None,
        prior=prior,
        given_priors=given or None,
    )


def _prior_told(model: FittedModel) -> PriorTold | None:
    """Where the prior of the law comes from, and what it was, by coordinate."""
    prior, law = model.specification.prior, model.layout.law
    if prior is None:
        return None
    each = zip(law.coordinates, prior.mean, prior.sd.tolist(), strict=True)
    return PriorTold(prior.source, {name: PriorCoordinate(m, s) for name, m, s in each})


def _given_told(found: FittedModel) -> dict[str, GivenTold]:
    """The priors that were given as numbers, with the units of their parameters."""
    units = dict(zip(found.chains.names, found.chains.units, strict=True))
    given = found.specification.given
    return {g.name: GivenTold(g.mean, g.sd, units[g.name]) for g in given}


def _path_spread(found: FittedModel) -> PathSpread | None:
    """The spread between paths that the model lacks, where the records speak for one."""
    differ = paths_differ(found)
    if differ is None or differ.evidence < WORTH_A_NOTE:
        return None
    effect = None if differ.lacking else differ.effect
    return PathSpread(differ.sd, differ.evidence, differ.n_paths, effect)


def _heavier_tails(found: FittedModel) -> HeavierTails | None:
    """What heavy tails would gain, where the records ask for them."""
    gain = heavier_tails(found)
    return None if gain is None or gain <= HEAVY_TAILS else HeavierTails(gain)


def prior_dominated(model: FittedModel) -> dict[str, PriorDominated]:
    """The parameters that the records hardly narrow, by their coordinate."""
    from scipy.stats import truncnorm  # noqa: PLC0415 (slow)

    layout = model.layout
    # The paper's methods have a σ of their own.
    n_slots = len(layout.slots) if model.knows_errors else len(layout.law.coordinates)
    found = {}
    for k, slot in enumerate(layout.slots[:n_slots]):
        prior = truncnorm(*slot.bounds, loc=slot.mean, scale=slot.sd)
        mean, sd = float(prior.mean()), float(prior.std())
        draws = np.log(model.draws[:, k]) if slot.lognormal else model.draws[:, k]
        ratio = float(np.std(draws, ddof=1)) / sd
        if ratio > STILL_PRIOR:
            moved = (float(np.mean(draws)) - mean) / sd
            found[slot.name] = PriorDominated(ratio, moved)
    return found


def _all_draws(found: FittedModel) -> Iterator[tuple[str, Floats, str]]:
    """Name, draws and unit of every parameter, offsets of paths last."""
    for k, (name, unit) in enumerate(zip(found.chains.names, found.chains.units, strict=True)):
        yield name, found.chains.draws[..., k].ravel(), unit
    plan = found.posterior.plan
    for name, told, g in zip(plan.names, plan.told, plan.of, strict=True):
        # Winters and storms are past: their spread is what matters.
        if plan.lasting[g] and name in found.offsets:
            yield told, found.offsets[name], "log friction"


def summary(draws: Floats, unit: str) -> ParameterSummary:
    """Mean, sd, mode and 5 and 95 % quantiles of draws `[n]`."""
    low, high = np.quantile(draws, [0.05, 0.95])
    return ParameterSummary(
        mean=float(draws.mean()),
        sd=float(draws.std(ddof=1)),
        mode=mode(draws),
        q05=float(low),
        q95=float(high),
        unit=unit,
    )


def mode(draws: Floats) -> float:
    """Where the density of draws `[n]` is highest, by a normal kernel.

    Its width is Silverman's rule, which a long tail does not widen.
    """
    from scipy.stats import gaussian_kde  # noqa: PLC0415 (slow)

    draws = draws[:: max(1, len(draws) // KDE_DRAWS)]
    middle, width = float(np.median(draws)), float(np.ptp(draws))
    if not 1e-12 * float(np.max(np.abs(draws))) < width < np.inf:
        return middle
    z = (draws - middle) / width  # whose squares neither vanish nor overflow
    sd = float(np.std(z, ddof=1))
    kernel = min(sd, float(np.ptp(np.quantile(z, [0.25, 0.75]))) / 1.349)
    # Where half of the draws are all but one value, that is it.
    if kernel <= NARROWEST * sd:
        return middle
    density = gaussian_kde(z / sd, bw_method=0.9 * kernel / sd * len(z) ** -0.2)
    # Places close together where the draws are dense.
    x = np.quantile(z, np.linspace(0.005, 0.995, KDE_POINTS))
    return float(middle + width * x[np.argmax(density(x / sd))])
