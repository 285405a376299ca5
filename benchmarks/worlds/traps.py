"""What real records do and the model of a world does not: storms, winters, few paths, wrong errors.

Nothing here is shared with the likelihood.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import date, timedelta

import numpy as np

from avahazard.records.collection import Records
from avahazard.synth.effects import CATALOGUE, WorldEffect
from avahazard.synth.world import World

STORM_EVENTS = 10
"""Avalanches of a storm, on average."""
STORM_SD = WINTER_SD = 0.11
N_WINTERS = 20


def storms(world: World, strength: float) -> dict[str, object]:
    """Avalanches come in storms of three days, on any path, that share their snow."""
    rng = world.generator("storms")
    n_storms = max(2, sum(s.n_events for s in world.sites) // STORM_EVENTS)
    winter, day = rng.integers(1921, 2021, n_storms), rng.integers(0, 148, n_storms)
    # Storms differ in size.
    of = rng.choice(n_storms, len(world.path), p=rng.dirichlet(np.full(n_storms, 8.0)))
    later = rng.integers(0, 3, len(of))
    _set_dates(world, winter[of], day[of] + later)
    shift = STORM_SD * strength * rng.normal(size=n_storms)
    world.log_mu += shift[of]
    return {"sd": STORM_SD * strength, "n_storms": n_storms}


def winters(world: World, strength: float) -> dict[str, object]:
    """All avalanches are of twenty winters, which differ."""
    rng = world.generator("winters")
    known = rng.choice(np.arange(1921, 2021), N_WINTERS, replace=False)
    of = rng.integers(0, N_WINTERS, len(world.path))
    _set_dates(world, known[of], world.day)
    world.log_mu += (WINTER_SD * strength * rng.normal(size=N_WINTERS))[of]
    return {"sd": WINTER_SD * strength, "n_winters": N_WINTERS}


def _set_dates(world: World, winter, day) -> None:  # type: ignore[no-untyped-def]
    world.day = day
    world.dates = [
        date(int(w) - 1, 12, 1) + timedelta(int(d)) for w, d in zip(winter, day, strict=True)
    ]


def path_columns(world: World, strength: float) -> dict[str, object]:
    """Columns of the paths that do nothing: the aspect in degrees and the area."""
    rng = world.generator("path columns")
    n = len(world.sites)
    world.columns["aspect"] = np.round(rng.uniform(0.0, 360.0, n))[world.path]
    world.columns["area_ha"] = np.round(rng.lognormal(2.5, 0.6, n), 1)[world.path]
    return {"strength": strength}


def stated(records: Records, errors: Mapping[str, float]) -> Records:
    """The same records, whose errors are stated otherwise: fields of events by name."""
    return replace(records, events=tuple(replace(e, **errors) for e in records.events))


def declared_limit(world: World, strength: float) -> dict[str, object]:
    """The same records as where short runouts are not seen, and the limits of sight declared."""
    told = CATALOGUE["observation-limit"](world, strength)
    world.limit_known = True
    return told


DECLARED = "declared limit"
TRAPS: dict[str, WorldEffect] = {
    "storms": storms,
    "winters": winters,
    "path columns": path_columns,
    DECLARED: declared_limit,
}
