"""What an effect is: a small file with its meaning, its parameters and what it acts on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.groups import Groups
from avahazard.effects.site import Site
from avahazard.physics.resistance import Resistance

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
Scale = Callable[[Floats], float]


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect ready for use: its parameters, and the one thing that it acts on.

    `motion(site, resistance, values)`: the resistance with this effect added.
    `design(columns)`: columns `[n_events, n_parameters]` added to log friction.
    `shift(columns, values)`: metres `[n_events]` added to the elevation that is recorded.
    `advance(columns, values)`: metres `[n_events]` along the path, record ahead of the block.
    `limit(columns, values)`: elevation `[n_events]` above which a stop is not seen (nan: none).
    `record_scale(values)`: factor on the stated errors of the records.
    `volume_scale(values)`: factor on the stated errors of the volumes.
    `groups(columns)`: groups of events, each with a random offset of log friction; the one
    parameter is the spread of these, normal about zero, with a half-normal prior.
    """

    key: str
    parameters: tuple[Parameter, ...] = ()
    motion: Motion | None = None
    design: Design | None = None
    shift: Record | None = None
    advance: Record | None = None
    limit: Record | None = None
    record_scale: Scale | None = None
    volume_scale: Scale | None = None
    groups: Callable[[EventColumns], Groups] | None = None
    speed_dependent: bool = False

    @property
    def neutral(self) -> Floats:
        """Neutral values `[n_parameters]`."""
        return np.array([p.neutral for p in self.parameters])

    @property
    def acts_on(self) -> str:
        """What it acts on, in words."""
        if self.design is not None or self.groups is not None:
            return "friction"
        if self.volume_scale is not None:
            return "the error of the volume"
        if self.record_scale is not None:
            return "the error of the record"
        return "the motion" if self.motion is not None else "the record"


def nothing_lacks(_columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    """For effects that any data will do for."""
    return None


def no_facts(_columns: EventColumns, _sites: Sequence[Site]) -> Facts:
    """For effects that take nothing from the data."""
    return {}


def nowhere(_columns: EventColumns, _sites: Sequence[Site]) -> str | None:
    """For effects of which the records do not say where they would act."""
    return None


def never(_columns: EventColumns, _sites: Sequence[Site]) -> bool:
    """For effects of which the data do not state what they would estimate."""
    return False


@dataclass(frozen=True, slots=True)
class Setting:
    """A setting of the model that an effect is, instead of something added to the block.

    `field` of the specification takes `value`, or where that is None the most likely of its other
    values. Where `without` is given the base model has the effect, and `without` is the value
    that leaves it out. `acts_on` says in words what the setting is of.
    """

    field: str
    acts_on: str
    value: str | bool | None = None
    without: str | bool | None = None

    @property
    def in_base(self) -> bool:
        """Whether the base model has it, and can be made without it."""
        return self.without is not None


@dataclass(frozen=True, slots=True)
class Definition:
    """An entry of the catalogue: what it means, what it needs, and how it is built.

    `lacking(columns, sites)` says in one sentence what the data lack for it, or None.
    `facts(columns, sites)` takes levels, knots and ranges from the data of the calibration;
    they are stored with the model. `build(facts)` gives the effect. `changes` is the setting of
    the model that the effect is, where it is one and nothing is built.

    What others ask of an effect, each with the common answer:

    - `event_columns`: friction or front depends on columns of the event itself, besides its path,
      volume and release; an avalanche to come is then like recorded ones in these.
    - `uses_volume`: friction depends on the volume, whatever the model's law.
    - `limits_speed`: it holds the speed on any steep and long path, as friction alone does not.
    - `nuisance(columns, sites)`: one that the diagnosis grants before it blames anything on
      physics; it says what the data lack for that, which may be less than for its name.
    - `granted_unasked`: it is granted even where the records do not ask for it.
    - `says_what_is_seen`: it is about which avalanches were recorded at all. The diagnosis tests it
      by itself, and what it finds on the motion must hold beside it.
    - `names_cause`: False for a smooth curve, which is no physics yet: a verdict that rests on
      such alone is `unexplained`, and it needs no margin of evidence.
    - `column`: the column that the effect is about; a smooth of it would only repeat the effect.
    - `reads`: the column of numbers that it goes by where a smooth of that is another effect.
    - `settled(columns, sites)`: the data state already what it would estimate, so that it is no
      candidate.
    - `seen_in(columns, sites)`: where the records have what the effect is about, in a sentence.
    - `trees`: where it acts on a path it is drawn as trees.
    - `order`: its place in the list; equal ones stand by key.
    """

    key: str
    meaning: str
    needs: str
    build: Callable[[Facts], Effect]
    lacking: Callable[[EventColumns, Sequence[Site]], str | None] = nothing_lacks
    facts: Callable[[EventColumns, Sequence[Site]], Facts] = no_facts
    changes: Setting | None = None
    event_columns: bool = False
    uses_volume: bool = False
    limits_speed: bool = False
    nuisance: Callable[[EventColumns, Sequence[Site]], str | None] | None = None
    granted_unasked: bool = False
    says_what_is_seen: bool = False
    names_cause: bool = True
    column: str | None = None
    reads: str | None = None
    settled: Callable[[EventColumns, Sequence[Site]], bool] = never
    seen_in: Callable[[EventColumns, Sequence[Site]], str | None] = nowhere
    trees: bool = False
    order: int = 1000

    @property
    def in_base(self) -> bool:
        """Whether the base model has it, so that `--without` can leave it out."""
        return self.changes is not None and self.changes.in_base
