"""Worlds that are harder than the plain ones, each an arm of the study of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.path import Profile
from benchmarks.coverage_study.world import TrueWorld, true_world

TAU = 0.12
"""Paths differ by so much (sd on log friction)."""
UNSEEN, LEFT = 0.3, 1.0 / 3.0


def with_a_third_left(seed: int) -> TrueWorld:
    """Profiles for the calibration end where a third of the records lie beyond.

    The runout of 100 years is then given on the whole profile.
    """
    world = true_world(seed)
    profiles = tuple(_cut(world.records, p) for p in world.records.profiles)
    ends = {p.path_id: p for p in profiles}
    events = []
    for event in world.records.events:
        profile = ends[event.path_id or ""]
        beyond = event.left_profile
        if event.runout_elevation_m is not None:
            beyond = event.runout_elevation_m < profile.y_m[-1]
        if event.runout_x_m is not None:
            beyond = event.runout_x_m > profile.x_m[-1]
        place = {"runout_elevation_m": None, "runout_x_m": None, "left_profile": True}
        events.append(replace(event, **place) if beyond else event)  # type: ignore[arg-type]
    told = Records(world.records.paths, profiles, tuple(events), world.records.speeds)
    return replace(world, told=told)


def _cut(records: Records, profile: Profile) -> Profile:
    """The profile up to where two thirds of its records lie."""
    mine = [e for e in records.events if e.path_id == profile.path_id]
    places = []
    for event in mine:
        x = event.runout_x_m
        if event.runout_elevation_m is not None:
            x = float(np.interp(-event.runout_elevation_m, -profile.y_m, profile.x_m))
        places.append(profile.x_m[-1] if x is None else x)
    end = float(np.quantile(places, 1.0 - LEFT))
    n = max(int(np.searchsorted(profile.x_m, end)), 3)
    cover = None if profile.land_cover is None else profile.land_cover[:n]
    return replace(profile, x_m=profile.x_m[:n], y_m=profile.y_m[:n], land_cover=cover)


PLAIN = "plain"
ARMS: dict[str, Callable[[int], TrueWorld]] = {
    PLAIN: true_world,
    "paths differ": lambda seed: true_world(seed, tau=TAU),
    "limit of sight": lambda seed: true_world(seed, unseen=UNSEEN),
    "a third left": with_a_third_left,
}
