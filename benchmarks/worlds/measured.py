"""A world once what `diagnose` asked for is measured: speeds on some of its events."""

from __future__ import annotations

from dataclasses import replace

from avahazard.criticism.diagnosis.measurements import N_MIDDLES, N_TRACKS
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.collection import Records
from avahazard.records.event import Speed
from avahazard.synth.making import make_world
from benchmarks.worlds.arms import Plan
from benchmarks.worlds.outside import EFFECTS
from benchmarks.worlds.traps import TRAPS, stated

SHARE = 0.3
"""Share of events whose speeds are measured in the arms that ask again with speeds."""


def with_speeds(plan: Plan, share: float = SHARE) -> Records:
    """The same world with speeds along the tracks of a share of its events."""
    settings = replace(plan.settings, speeds=share)
    own = {**EFFECTS, **TRAPS}
    records, _ = make_world(
        plan.seed, plan.n_events, plan.n_paths, plan.effects, settings, own_effects=own
    )
    return stated(records, plan.stated)


def as_told(plan: Plan, measurement: str) -> Observations | None:
    """The observations with this measurement made; None if it asks for something else."""
    if "track" not in measurement:
        return None
    middles = "mid-track" in measurement
    records = with_speeds(plan, (N_MIDDLES if middles else N_TRACKS) / plan.n_events)
    if middles:
        records = replace(records, speeds=_middles(records.speeds))
    return build_observations(records)


def _middles(speeds: tuple[Speed, ...]) -> tuple[Speed, ...]:
    """Of each event the speed halfway along those measured."""
    tracks: dict[str, list[Speed]] = {}
    for one in speeds:
        tracks.setdefault(one.event_id, []).append(one)
    return tuple(track[len(track) // 2] for track in tracks.values())
