"""Worlds drawn from prior and model, for simulation-based calibration of the marginal method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.friction_scatter import volume_share
from avahazard.inference.model.observations import (
    ELEVATION,
    LEFT,
    Observations,
    build_observations,
)
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from tests.inference.studies import SNOW, posterior, profile

VOLUME_MEDIAN, VOLUME_SPREAD = np.exp(10.5), 1.0
PRIORS = {
    "n in 1e-6/m3": (1.0, 1.0),
    "log sigma": (np.log(0.15), 0.3),
    "sigma_n": (0.0, 0.3),
    "beta": (0.05, 0.03),
}
"""Narrower than the product's, so that frictions stay where blocks move and stop on the bowl. The
friction of small volumes has its case's centre and a standard deviation of 0.1 of its log."""
LEVELS = {"log a": 0.0, "log alpha": 0.05 * 10.5}
"""The coordinate of that friction in each law: its log, less this."""


@dataclass(frozen=True)
class Case:
    """A model and the records of its worlds.

    `a` is the friction about which they lie, `volume_error` the relative error of volumes. With
    `dropped` releases lie up to so many metres below the top, with `seen_below` stops above so
    many metres (on the first path; the others lie higher) are not seen. `n_worlds` are made.
    """

    effects: tuple[str, ...] = ()
    n_events: int = 40
    n_paths: int = 2
    a: float = 0.55
    law: str = "exponential"
    volume_error: float = 1e-6
    dropped: float = 0.0
    seen_below: float | None = None
    n_worlds: int = 100


@cache
def _ground(case: Case) -> tuple[tuple[Path, ...], tuple[Profile, ...]]:
    """Bowls, every other one cut short, so that some events leave it."""
    whole = [profile(k % 6) for k in range(case.n_paths)]
    cut = [np.where(p.x_m <= (1450.0, 1900.0)[k % 2])[0] for k, p in enumerate(whole)]
    names = [f"P{k}" for k in range(case.n_paths)]
    limit = case.seen_below
    return (
        tuple(
            Path(
                name,
                section=("channelled", "open")[k % 2],
                observed_below_m=None if limit is None else limit + 60.0 * (k % 6),
            )
            for k, name in enumerate(names)
        ),
        tuple(
            Profile(name, p.x_m[c], p.y_m[c], tuple(np.array(p.land_cover)[c]))
            for name, p, c in zip(names, whole, cut, strict=True)
        ),
    )


def groups(n_events: int) -> dict[str, np.ndarray]:
    """Labels of winters and storms: two of three events fell in pairs, two pairs a winter."""
    i = np.arange(n_events)
    storm = np.where(i < 2 * n_events // 3, i // 2, i)
    winter = np.where(i < 2 * n_events // 3, i // 4, i)
    return {"winter-effect": winter, "storm-effect": storm}


def _date(i: int, n_events: int) -> str:
    """A day of the winter and storm of an event; days of a storm are one apart."""
    of = groups(n_events)
    winter, storm = int(of["winter-effect"][i]), int(of["storm-effect"][i])
    month = ("12", "02", "04")[storm % 2 if i < 2 * n_events // 3 else i % 3]
    # A December belongs to the winter that ends in the next year.
    return f"{1921 + winter - (month == '12')}-{month}-{10 + i % 2:02d}"


def _events(case: Case, recorded: np.ndarray, rng: np.random.Generator) -> tuple[Event, ...]:
    """Events with all columns, and no stop yet."""
    paths, profiles = _ground(case)
    wind = rng.standard_normal(case.n_events)
    return tuple(
        Event(
            f"e{i}",
            paths[i % case.n_paths].path_id,
            date=_date(i, case.n_events),
            left_profile=True,
            release_elevation_m=float(profiles[i % case.n_paths].y_m[0])
            - case.dropped * (i // case.n_paths % 4) / 3.0,
            volume_m3=float(v),
            volume_rel_sigma=case.volume_error,
            deposit_length_m=30.0 + 3.0 * (i * 7 % 40),
            covariates={"snow_type": SNOW[i * 7 % 5], "wind": float(wind[i])},
        )
        for i, v in enumerate(recorded)
    )


def narrowed(observations: Observations, case: Case) -> Posterior:
    """The model with the priors of these worlds."""
    model = posterior(observations, *case.effects, law=case.law)
    priors = PRIORS | {name: (np.log(case.a) + at, 0.1) for name, at in LEVELS.items()}
    slots = tuple(
        replace(s, mean=priors[s.name][0], sd=priors[s.name][1]) if s.name in priors else s
        for s in model.layout.slots
    )
    model.layout = replace(model.layout, slots=slots)
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
    """The model on records of a world drawn from it and its prior, and the true coordinates.

    With a deliberate `fault` the effects' parameters were larger by so many of their priors' sds.
    """
    n = case.n_events
    recorded = VOLUME_MEDIAN * np.exp(VOLUME_SPREAD * rng.standard_normal(n))
    paths, profiles = _ground(case)
    given = build_observations(Records(paths, profiles, _events(case, recorded, rng)))
    given = replace(given, sigma=rng.uniform(10.0, 25.0, n))
    model = narrowed(given, case)
    u = from_prior(model, rng)
    law, layout = model.layout.law, model.layout
    moved = u + fault * np.array([s.sd for s in layout.slots])
    done = np.where(np.arange(len(u)) > layout.scatter, moved, u)
    done = np.clip(done, layout.low, layout.high)
    values = layout.effect_values(done)
    tables = model.nodes.predicted_at(done)
    # The true volumes are those that the records of volumes leave.
    volumes = model.volumes(done)
    volume = np.exp(volumes.mean + volumes.sd * rng.standard_normal(n))
    location = law.log_friction(done[: len(law.coordinates)], volume)
    for effect in model.effects:
        if effect.design is not None:
            location = location + effect.design(given.columns) @ values[effect.key]
    of_groups = {"path-effect": np.arange(n) % case.n_paths} | groups(n)
    for key, slot in layout.spreads.items():
        offsets = 0.2 * done[slot] * rng.standard_normal(n)
        location = location + offsets[of_groups[key]]
    log_scatter = np.full(n, done[layout.scatter])
    if layout.scatter_slope is not None:
        bent = done[layout.scatter_slope] * volume_share(volume, layout.reference_volume)
        log_scatter = np.maximum(log_scatter - bent, layout.slots[layout.scatter].low)
    kind, observed = np.full(n, LEFT), np.full(n, np.nan)
    nearest_to = 0.5 * (np.log(MU[1:]) + np.log(MU[:-1]))
    lacking = np.arange(n)
    while len(lacking):
        nu = location + np.exp(log_scatter) * rng.standard_normal(n)
        error = tables.sigma * rng.standard_normal(n)
        left_out = []
        for i in lacking:
            kind[i], observed[i] = LEFT, np.nan
            if tables.status[i, np.searchsorted(nearest_to, nu[i])] == LEFT_PROFILE:
                continue
            kind[i] = ELEVATION
            observed[i] = np.interp(nu[i], np.log(MU), tables.elevation[i]) + error[i]
            # What is not seen is not recorded: another avalanche is.
            if observed[i] > given.limit[i]:
                left_out.append(i)
        lacking = np.array(left_out, dtype=int)
    return narrowed(replace(given, kind=kind, observed=observed), case), u
