"""What an effect is: a small file with its meaning, its parameters and what it acts on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.columns import EventColumns
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance

Floats = NDArray[np.float64]
Facts = dict[str, Any]
"""What an effect takes from the data it is calibrated on (levels, knots, ranges), as JSON."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of an effect: a normal prior cut to its plausible range [low, high].

    At `neutral` the effect is not there. `grid`: values at which effects on the motion and on
    the record are tabulated (between them the likelihood is interpolated).
    """

    name: str
    unit: str
    neutral: float
    prior_mean: float
    prior_sd: float
    low: float = -np.inf
    high: float = np.inf
    grid: tuple[float, ...] = ()


Motion = Callable[[Site, Resistance, Floats], Resistance]
Design = Callable[[EventColumns], Floats]
Record = Callable[[EventColumns, Floats], Floats]


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect ready for use: its parameters, and the one thing that it acts on.

    `motion(site, resistance, values)`: the resistance with this effect added.
    `design(columns)`: columns `[n_events, n_parameters]` added to log friction.
    `shift(columns, values)`: metres `[n_events]` added to the elevation that is recorded.
    `advance(columns, values)`: metres `[n_events]` along the path, record ahead of the block.
    `limit(columns, values)`: elevation `[n_events]` above which a stop is not seen (nan: none).
    `groups(columns)`: group index `[n_events]` of a random offset of log friction, -1 for none.
    """

    key: str
    parameters: tuple[Parameter, ...] = ()
    motion: Motion | None = None
    design: Design | None = None
    shift: Record | None = None
    advance: Record | None = None
    limit: Record | None = None
    groups: Callable[[EventColumns], NDArray[np.int64]] | None = None
    speed_dependent: bool = False

    @property
    def neutral(self) -> Floats:
        """Neutral values `[n_parameters]`."""
        return np.array([p.neutral for p in self.parameters])


def nothing_lacks(_columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    """For effects that any data will do for."""
    return None


def no_facts(_columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    """For effects that take nothing from the data."""
    return {}


@dataclass(frozen=True, slots=True)
class Definition:
    """An entry of the catalogue: what it means, what it needs, and how it is built.

    `lacking(columns, sites)` says in one sentence what the data lack for it, or None.
    `facts(columns, sites)` takes levels, knots and ranges from the data of the calibration;
    they are stored with the model. `build(facts)` gives the effect. Where `changes` names a
    field of the specification (`law`, `scatter`, `centrifugal`), the effect is that change.
    """

    key: str
    meaning: str
    needs: str
    build: Callable[[Facts], Effect]
    lacking: Callable[[EventColumns, Sequence[Site]], str | None] = nothing_lacks
    facts: Callable[[EventColumns, Sequence[Site]], Facts] = no_facts
    changes: str | None = None
