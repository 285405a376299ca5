"""Datasets drawn from prior and model, for simulation-based calibration of the marginal method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects.effect import FrictionEffect, LimitEffect
from avahazard.effects.site import release_place
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.track_nodes import drawn_speeds
from avahazard.inference.model.friction_model import volume_share
from avahazard.inference.model.observations import ELEVATION, LEFT, Observations, SpeedRecord
from avahazard.inference.model.specification import Specification
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from tests.inference.sbc_records import Case, groups, without_stops

PRIORS = {
    "n in 1e-6/m3": (1.0, 1.0),
    "log sigma": (np.log(0.15), 0.3),
    "sigma_n": (0.0, 0.3),
    "beta": (0.05, 0.03),
    "log c in 1e5 m3": (1.5, 0.5),
    "log n": (0.0, 0.3),
    "log mu_inf/a": (-0.5, 0.3),
    "log n in 1e-6/m3": (2.5, 0.5),
    "log track sigma": (np.log(0.05), 0.3),
}
"""Narrower than the product's, so that frictions stay where blocks move and stop on the bowl. The
friction of small volumes has its case's centre and a standard deviation of 0.1 of its log."""
LEVELS = {"log a": 0.0, "log alpha": 0.05 * 10.5}
"""The coordinate of that friction in each law: its log, less this."""


def narrowed(observations: Observations, case: Case) -> Posterior:
    """The model with the priors of these datasets."""
    base = Specification(law=case.law, centrifugal=case.centrifugal)
    # Before there are any stops, no effect can be estimated from them.
    specification, facts = with_effects(observations, base, case.effects, granted=True)
    if "observation-limit" in case.effects:
        # Fixed before the records are; the product takes the highest of these.
        names = [site.path.path_id for site in observations.sites]
        paths = {name: {"highest_m": case.highest_seen(k)} for k, name in enumerate(names)}
        facts["observation-limit"] = {"paths": paths}
    model = assemble(observations, specification, facts)
    priors = PRIORS | {name: (np.log(case.a) + at, 0.1) for name, at in LEVELS.items()}
    slots = tuple(
        replace(s, mean=priors[s.name][0], sd=priors[s.name][1]) if s.name in priors else s
        for s in model.layout.slots
    )
    model.friction = replace(model.friction, layout=replace(model.layout, slots=slots))
    return model


def from_prior(model: Posterior, rng: np.random.Generator) -> np.ndarray:
    """Coordinates drawn from the prior, cut to its bounds."""
    layout = model.layout
    u = np.array([rng.normal(s.mean, s.sd) for s in layout.slots])
    while np.any(out := (u < layout.low) | (u > layout.high)):
        again = np.array([rng.normal(s.mean, s.sd) for s in layout.slots])
        u = np.where(out, again, u)
    return u


def world(case: Case, rng: np.random.Generator, fault: float = 0.0) -> tuple[Posterior, np.ndarray]:
    """The model on records of a dataset drawn from it and its prior, and the true coordinates.

    With a deliberate `fault` the effects' parameters were larger by so many of their priors' sds.
    """
    given = without_stops(case, rng)
    model = narrowed(given, case)
    while True:
        u = from_prior(model, rng)
        found = _recorded(model, case, u, fault, rng)
        # A dataset whose records are not possible under any detection margin is none of these.
        if not np.any(found.observed > _highest_seen(case, found)):
            return narrowed(found, case), u


def _recorded(
    model: Posterior, case: Case, u: np.ndarray, fault: float, rng: np.random.Generator
) -> Observations:
    """The model's observations with records drawn at coordinates u, moved by the `fault`."""
    layout, given, n = model.layout, model.observations, case.n_events
    moved = u + fault * np.array([s.sd for s in layout.slots])
    done = np.where(np.arange(len(u)) > layout.scatter, moved, u)
    done = np.clip(done, layout.low, layout.high)
    tables = model.nodes.predicted_at(done)
    location, scatter = _friction(model, case, done, rng)
    limit = _limit(model, done)
    kind, observed = np.full(n, LEFT), np.full(n, np.nan)
    nearest_to = 0.5 * (np.log(MU[1:]) + np.log(MU[:-1]))
    log_friction, lacking = np.full(n, np.nan), np.arange(n)
    while len(lacking):
        nu = location + scatter * rng.standard_normal(n)
        error = tables.sigma * rng.standard_normal(n)
        left_out = []
        for i in lacking:
            kind[i], observed[i], log_friction[i] = LEFT, np.nan, nu[i]
            if tables.status[i, np.searchsorted(nearest_to, nu[i])] == LEFT_PROFILE:
                continue
            kind[i] = ELEVATION
            stop = np.interp(nu[i], np.log(MU), tables.elevation[i])
            observed[i] = stop + error[i]
            # What is undetected is not recorded: another avalanche is. A declared limit is of
            # places, an estimated one of records.
            declared = np.isfinite(given.limit[i])
            if (stop if declared else observed[i]) > limit[i]:
                left_out.append(i)
        lacking = np.array(left_out, dtype=int)
    found = replace(given, kind=kind, observed=observed)
    if layout.track_scatter is None:
        return found
    on_track = float(np.exp(done[layout.track_scatter]))
    return replace(found, speeds=_measured(found, tables, np.exp(log_friction), on_track, rng))


def _friction(
    model: Posterior, case: Case, u: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Location and scatter of each event's log friction `[n_events]`, with its volume drawn."""
    layout, n = model.layout, case.n_events
    values = layout.effect_values(u)
    # The true volumes are those that the records of volumes leave.
    volumes = model.volumes(u)
    volume = np.exp(volumes.mean + volumes.sd * rng.standard_normal(n))
    location = layout.law.log_friction(u[: len(layout.law.coordinates)], volume)
    if "two-kinds" in values:
        share, shift = values["two-kinds"]
        location = location + shift * ((rng.uniform(size=n) < share) - share)
    for effect in model.effects:
        if isinstance(effect, FrictionEffect):
            location = location + effect.design(model.observations.columns) @ values[effect.key]
    of_groups = {"path-effect": np.arange(n) % case.n_paths} | groups(n)
    for key, slot in layout.spreads.items():
        offsets = 0.2 * u[slot] * rng.standard_normal(n)
        location = location + offsets[of_groups[key]]
    log_scatter = np.full(n, u[layout.scatter])
    if layout.scatter_slope is not None:
        bent = u[layout.scatter_slope] * volume_share(volume, layout.reference_volume)
        log_scatter = np.maximum(log_scatter - bent, layout.slots[layout.scatter].low)
    return location, np.exp(log_scatter)


def _highest_seen(case: Case, observations: Observations) -> np.ndarray:
    """Elevations (m) that no record of each event lies above `[n_events]`, inf for most cases."""
    if "observation-limit" not in case.effects:
        return np.full(case.n_events, np.inf)
    highest = [case.highest_seen(k) for k in range(case.n_paths)]
    return np.array(highest)[observations.columns.path_index]


def _limit(model: Posterior, u: np.ndarray) -> np.ndarray:
    """Elevations (m) above which stops are undetected `[n_events]`, declared or by an effect."""
    values = model.layout.effect_values(u)
    for effect in model.effects:
        if isinstance(effect, LimitEffect):
            return np.asarray(effect.limit(model.observations.columns, values[effect.key]))
    return model.observations.limit


def _measured(
    found: Observations,
    tables: Predicted,
    friction: np.ndarray,
    scatter: float,
    rng: np.random.Generator,
) -> tuple[SpeedRecord, ...]:
    """The tracks under `friction` `[n_events]` that is uneven, measured down to their stops."""
    tracks = []
    for track, block in zip(found.speeds, tables.speeds, strict=True):
        i = track.event
        smooth = found.sites[found.columns.path_index[i]].smooth
        left = found.kind[i] == LEFT
        stop = smooth.x_max if left else release_place(smooth, float(found.observed[i]))
        k = int(np.searchsorted(track.x, stop))
        if k == 0:
            continue
        made = SpeedRecord(i, track.x[:k], track.speed[:k], track.sigma[:k], track.release_x, stop)
        square = np.array([np.interp(friction[i], MU, column**2) for column in block.speed.T[:k]])
        drawn = drawn_speeds(square[:, None], made, scatter, rng, arrives=False)
        tracks.append(replace(made, speed=drawn[:, 0]))
    return tuple(tracks)
