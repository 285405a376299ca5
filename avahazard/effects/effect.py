"""What an effect is: a small file with its meaning, its parameters and what it acts on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avahazard.effects.columns import EventColumns
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance

Floats = NDArray[np.float64]


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
RecordShift = Callable[[EventColumns, Floats], Floats]


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect acts through exactly one of these; all take its parameter values.

    `motion(site, resistance, values)`: the resistance with this effect added.
    `design(columns)`: columns `[n_events, n_parameters]` added to log friction.
    `scatter(columns)`: columns `[n_events, n_parameters]` added to log scatter.
    `shift(columns, values)`: metres `[n_events]` added to the elevation that is recorded.
    `advance(columns, values)`: metres `[n_events]` along the path, record ahead of the block.
    `limit(columns, values)`: elevation `[n_events]` above which a stop is not seen (nan: none).
    `groups(columns)`: group index `[n_events]` of a random offset of log friction, -1 for none.
    `refine(parameters, columns, sites)` sets ranges that depend on the data.
    """

    key: str
    meaning: str
    needs: str
    parameters: tuple[Parameter, ...] = ()
    missing: Callable[[EventColumns, Sequence[Site]], str | None] = field(
        default=lambda _columns, _sites: None
    )
    motion: Motion | None = None
    design: Design | None = None
    scatter: Design | None = None
    shift: RecordShift | None = None
    advance: RecordShift | None = None
    limit: RecordShift | None = None
    groups: Callable[[EventColumns], NDArray[np.int64]] | None = None
    refine: (
        Callable[[tuple[Parameter, ...], EventColumns, Sequence[Site]], tuple[Parameter, ...]]
        | None
    ) = None
    speed_dependent: bool = False

    @property
    def neutral(self) -> Floats:
        """Neutral values `[n_parameters]`."""
        return np.array([p.neutral for p in self.parameters])
