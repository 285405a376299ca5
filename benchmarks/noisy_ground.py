"""Worlds whose blocks run down true ground, of which the product sees points with errors.

The ground, its blocks and its errors are made here and in `avahazard.synth`, which share nothing
with the product's physics or its likelihood.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.path import Profile
from avahazard.synth.integrator import make_track
from avahazard.synth.making import RUN_ON_M, concave_profile, make_sites, make_world
from avahazard.synth.settings import Settings, SitePlan


@dataclass(frozen=True, slots=True)
class NoisyPlan:
    """A world: its ground, and how far apart (m) and how wrong (m, one sd) its points are."""

    seed: int
    benched: bool = False
    spacing_m: float = 10.0
    sigma_m: float = 5.0
    told: bool = False
    n_events: int = 240
    n_paths: int = 9


def noisy_world(plan: NoisyPlan) -> tuple[Records, Records]:
    """The records with the points as they were measured, and with the true ground."""
    sites = make_sites(plan.seed, plan.n_paths, plan.n_events)
    if plan.benched:
        sites = tuple(_with_benches(site, plan.seed + k) for k, site in enumerate(sites))
    exact, _ = make_world(plan.seed, settings=Settings(), sites=sites)
    rng = np.random.default_rng([plan.seed, 8])
    profiles = tuple(measured(p, plan.spacing_m, plan.sigma_m, plan.told, rng)
                     for p in exact.profiles)  # fmt: skip
    return replace(exact, profiles=profiles), exact


def measured(
    true: Profile, spacing_m: float, sigma_m: float, told: bool, rng: np.random.Generator
) -> Profile:
    """Points of the true ground, so far apart, each elevation with an error of its own."""
    track = make_track(true.x_m, true.y_m)
    x = np.append(np.arange(true.x_m[0], true.x_m[-1] - 0.5 * spacing_m, spacing_m), true.x_m[-1])
    y = track.elevation(x) + rng.normal(0.0, sigma_m, len(x))
    at = np.clip(np.searchsorted(true.x_m, x, "right") - 1, 0, len(true.x_m) - 1)
    cover = None if true.land_cover is None else tuple(true.land_cover[i] for i in at)
    sigma = np.full(len(x), sigma_m) if told else None
    return Profile(true.path_id, x, np.round(y, 3), cover, elevation_sigma_m=sigma)


def _with_benches(site: SitePlan, seed: int) -> SitePlan:
    """The same site with benches 120 to 300 m long in the middle of its path."""
    rng = np.random.default_rng([seed, 9])
    true = site.profile
    drop = site.drop_m or float(np.ptp(true.y_m))
    length = float(true.x_m[-1]) - RUN_ON_M
    benches = (float(rng.uniform(0.2, 0.4)), length / rng.uniform(120.0, 300.0), rng.uniform())
    x, y = concave_profile(
        drop,
        float(true.y_m[0]),
        (1.0, 0.08),
        float(rng.uniform(1.3, 1.9)),
        (benches,),
        (400.0, 0.06),
    )
    return replace(site, profile=Profile(true.path_id, x, y))
