"""All records that belong together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile
from avahazard.records.simulation import Simulation


@dataclass(frozen=True, slots=True)
class Records:
    """Paths, their profiles, events and speeds, in the order in which they were read.

    Runs of flow models are without their peak pressures.

    `kept` is for what is made of them once (`lookup.of_path`).
    """

    paths: tuple[Path, ...] = ()
    profiles: tuple[Profile, ...] = ()
    events: tuple[Event, ...] = ()
    speeds: tuple[Speed, ...] = ()
    simulations: tuple[Simulation, ...] = ()
    kept: dict[str, Any] = field(default_factory=dict, init=False, repr=False, compare=False)
