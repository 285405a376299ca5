"""Small studies with a known law, for the tests of criticism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.inference.fitting.mode import Mode, find_mode
from avahazard.inference.likelihood.assemble import assemble, with_effects
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.records.collection import Event, Path, Profile, Records, Speed


def straight(n: int = 60, seed: int = 1) -> Records:
    """Events without a profile: L = H/μ, log μ normal about log 0.4 with sd 0.15."""
    rng = np.random.default_rng(seed)
    mu = 0.4 * np.exp(0.15 * rng.standard_normal(n))
    length = 1000.0 / mu + 20.0 * rng.standard_normal(n)
    return Records(
        events=tuple(
            Event(f"e{i}", fall_height_m=1000.0, runout_length_m=float(v), runout_sigma_m=20.0)
            for i, v in enumerate(length)
        )
    )


def levelled(shift: float, n_level: int, seed: int = 1, n: int = 80) -> Records:
    """`straight` with a column `rock`: its last `n_level` events have log friction `shift` more."""
    records = straight(n, seed)
    events = []
    for i, e in enumerate(records.events):
        own = i >= n - n_level
        length = (e.runout_length_m or 0.0) * np.exp(-shift * own)
        kind = {"rock": "lime" if own else "gneiss"}
        events.append(replace(e, runout_length_m=length, covariates=kind))
    return replace(records, events=tuple(events))


def slopes(n_paths: int = 3, n_each: int = 6, kind: str = "elevation", seed: int = 2) -> Records:
    """Paths of one parabola, y = 1000 - x + 2.5e-4 x², with stops scattered on it."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1800.0, 91)
    y = 1000.0 - x + 2.5e-4 * x**2
    events = []
    for p in range(n_paths):
        for i in range(n_each):
            stop = float(rng.uniform(900.0, 1500.0))
            height = 1000.0 - stop + 2.5e-4 * stop**2
            place = {"runout_x_m": stop} if kind == "x" else {"runout_elevation_m": height}
            events.append(Event(f"{p}-{i}", path_id=f"P{p}", **place))
    names = [f"P{p}" for p in range(n_paths)]
    return Records(
        paths=tuple(Path(name) for name in names),
        profiles=tuple(Profile(name, x, y) for name in names),
        events=tuple(events),
    )


def with_left(records: Records, n: int = 1) -> Records:
    """The records, the first `n` events of which ran beyond their profile."""
    left = [
        replace(e, left_profile=True, runout_elevation_m=None, runout_x_m=None)
        for e in records.events[:n]
    ]
    return replace(records, events=(*left, *records.events[n:]))


def with_speeds(records: Records, speed: float = 15.0) -> Records:
    """The records, the first event with three measured speeds."""
    event = records.events[0].event_id
    speeds = tuple(Speed(event, speed, 1.0, x_m=x) for x in (200.0, 400.0, 600.0))
    return replace(records, speeds=speeds)


def fitted(records: Records, *effects: str) -> tuple[Posterior, Mode]:
    """The posterior of the constant law with effects, and its mode."""
    observations = build_observations(records)
    specification, facts = with_effects(observations, Specification(law="constant"), effects)
    posterior = assemble(observations, specification, facts)
    return posterior, find_mode(posterior)


def draws_about(mode: Mode, n: int = 400, seed: int = 3) -> np.ndarray:
    """Draws of the normal about a mode, `[n, n_slots]`."""
    return np.random.default_rng(seed).multivariate_normal(mode.u, mode.covariance, n)
