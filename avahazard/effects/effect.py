"""What an effect is: a small file with its meaning, its parameters and what it acts on."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import EventColumns
from avahazard.effects.site import Site
from avahazard.physics.cells import Resistance

MIN_LEVEL = 5
"""Fewest events of a level, or on each side of a split, that can speak for it."""

DENSE = 2.5
"""Power by which plausible values of a parameter gather at one end of its range."""
Facts = dict[str, Any]
"""What an effect takes from the data it is calibrated on (levels, knots, ranges), as JSON."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter with a normal prior cut to [low, high]; at `neutral` there is no effect."""

    name: str
    unit: str
    neutral: float
    prior_mean: float
    prior_sd: float
    low: float = -np.inf
    high: float = np.inf

    def plausible(self, n: int) -> list[float]:
        """n values over a finite range, without the neutral one.

        Closer together near a bound that is neutral and most plausible, or, where the effect is
        gone at the highest value, near the lowest.
        """
        low, high, expected = self.low, self.high, self.prior_mean == self.neutral
        if self.neutral not in (low, high):
            return [float(v) for v in np.linspace(low, high, n) if v != self.neutral]
        shares, first, last = np.arange(1, n + 1) / n, self.neutral, low + high - self.neutral
        if not expected and self.neutral == high:
            shares, first, last = shares - 1.0 / n, low, high
        if expected or self.neutral == high:
            shares = shares**DENSE
        return [float(v) for v in first + shares * (last - first)]


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect ready for use, of a kind that its class says.

    One of no kind has no parameters: what it means is a `Setting` of the model. `paths` names that
    of each parameter where each acts on one path alone, so that nothing of it is known elsewhere.
    """

    key: str
    parameters: tuple[Parameter, ...]
    paths: tuple[str, ...] = field(default=(), kw_only=True)
    acts_on: ClassVar[str] = ""

    @property
    def neutral(self) -> Floats:
        """Neutral values `[n_parameters]`."""
        return np.array([p.neutral for p in self.parameters], np.float64)


@dataclass(frozen=True, slots=True)
class MotionEffect(Effect):
    """`resistance(site, resistance, values)`: the resistance with this effect added.

    Its mode is also sought along `shapes`, values of all of its parameters for one of the first.
    """

    resistance: Callable[[Site, Resistance, Floats], Resistance]
    speed_dependent: bool = False
    shapes: tuple[tuple[float, ...], ...] = ()
    acts_on: ClassVar[str] = "the motion"


@dataclass(frozen=True, slots=True)
class FrictionEffect(Effect):
    """`design(columns)`: columns `[n_events, n_parameters]` added to log friction."""

    design: Callable[[EventColumns], Floats]
    acts_on: ClassVar[str] = "friction"


@dataclass(frozen=True, slots=True)
class ScatterEffect(Effect):
    """`design(columns)`: columns `[n_events, n_parameters]` added to the log of the scatter."""

    design: Callable[[EventColumns], Floats]
    acts_on: ClassVar[str] = "the scatter of friction"


@dataclass(frozen=True, slots=True)
class KindsEffect(Effect):
    """Avalanches are of two unrecorded kinds.

    Its parameters are the share of the second kind and the shift of its log friction against the
    first; the mean of both is the law's.
    """

    acts_on: ClassVar[str] = "friction"


@dataclass(frozen=True, slots=True, eq=False)
class Groups:
    """Groups by name, and that of each event: `index` `[n_events]` into `names`, -1 for none.

    `alone`: an event without a group has an offset of its own; what is to come is in none that is
    known. Otherwise groups last, as paths do. `told` comes before the name where people read it.
    Names must not meet those of other effects' groups.
    """

    names: tuple[str, ...]
    index: Ints
    alone: bool = False
    told: str = ""


@dataclass(frozen=True, slots=True)
class GroupEffect(Effect):
    """`groups(columns)`: groups of events with random normal offsets; the parameter is their sd."""

    groups: Callable[[EventColumns], Groups]
    acts_on: ClassVar[str] = "friction"


@dataclass(frozen=True, slots=True)
class RecordEffect(Effect):
    """What is recorded of a stop; one of the three classes below."""

    acts_on: ClassVar[str] = "the record"


@dataclass(frozen=True, slots=True)
class ShiftEffect(RecordEffect):
    """`shift(columns, values)`: metres `[n_events]` added to the elevation that is recorded."""

    shift: Callable[[EventColumns, Floats], Floats]


@dataclass(frozen=True, slots=True)
class FrontEffect(RecordEffect):
    """`advance(columns, values)`: metres `[n_events]` along the path, record ahead of the block."""

    advance: Callable[[EventColumns, Floats], Floats]


@dataclass(frozen=True, slots=True)
class RecordErrorEffect(RecordEffect):
    """A factor on the stated errors of the records: its parameter is the log of that."""

    acts_on: ClassVar[str] = "the error of the record"


@dataclass(frozen=True, slots=True)
class LimitEffect(Effect):
    """`limit(columns, values)`: elevation `[n_events]` above which no stop is seen (nan: none)."""

    limit: Callable[[EventColumns, Floats], Floats]
    acts_on: ClassVar[str] = "the record"


@dataclass(frozen=True, slots=True)
class VolumeErrorEffect(Effect):
    """A factor on the stated errors of the volumes: its parameter is the log of that."""

    acts_on: ClassVar[str] = "the error of the volume"


Kind = TypeVar("Kind", bound=Effect)


def of_kind(effects: Iterable[Effect], kind: type[Kind]) -> list[Kind]:
    """Those of the effects that are of this kind."""
    return [effect for effect in effects if isinstance(effect, kind)]


def shapes_tables(effect: Effect) -> bool:
    """Whether its parameters change the tables of the records that are expected."""
    return isinstance(effect, MotionEffect | RecordEffect | LimitEffect)


Sites = Sequence[Site]
Answer = Callable[[EventColumns, Sites], str | None]
"""A sentence on the data, or None."""


def unless(enough: Callable[[EventColumns], Any], lack: str) -> Answer:
    """The sentence `lack`, unless the columns of the data are `enough`."""
    return lambda columns, _sites: None if enough(columns) else lack


def fewest_events(n: int) -> Answer:
    """What effects lack that need so many events."""
    return unless(lambda columns: len(columns) >= n, f"fewer than {n} events")


needs_profile = unless(
    lambda columns: np.any(columns.path_index >= 0), "no event lies on a path with a profile"
)
"""What effects lack that act along the profile of a path."""


def known(column: Floats) -> Floats:
    """The numbers of a column that are not missing."""
    return column[np.isfinite(column)]


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """A smooth effect as a curve over what it goes by, for people and for laws that it may be.

    `of` is the state or the column, in `unit`; the curve is of what `value` says, in `columns`
    `[n, n_parameters]` times the parameters, at places `x` `[n]`. It is 0 on average or, where
    `rests`, at the first place. An effect file, if one can have it, has it as the function `form`,
    whose first argument gives the state by the expression `state`, with `needs`. `path`: that on
    which it is, if on one.
    """

    of: str
    unit: str
    value: str
    x: Floats
    columns: Floats
    rests: bool = False
    form: str = ""
    state: str = ""
    needs: tuple[str, ...] = ()
    path: str | None = None

    def values_of(self, heights: Floats) -> Floats:
        """Parameters `[n_parameters]` of the curve nearest to heights `[n]` (least squares)."""
        return np.asarray(np.linalg.lstsq(self.columns, heights, rcond=None)[0])


@dataclass(frozen=True, slots=True)
class Setting:
    """A setting of the model that an effect is, instead of something added to the block.

    `field` of the specification takes `value`, or where that is None the most likely of its other
    values. Where the base model has the effect, `without` is the value that leaves it out.
    """

    field: str
    acts_on: str
    value: str | bool | None = None
    without: str | bool | None = None


@dataclass(frozen=True, slots=True)
class Definition:
    """An entry of the catalogue: what it means, what it needs, and how it is built.

    `lacking(columns, sites)` says in one sentence what the data lack for it, or None.
    `facts(columns, sites)` takes levels, knots and ranges from the data of the calibration, stored
    with the model; `build(facts)` gives the effect. `changes` is the setting of the model that it
    is, where nothing is built. What others ask of an effect, each with the common answer:

    - `event_columns`: friction or front depends on columns of the event itself, besides its path,
      volume and release; an avalanche to come is then like recorded ones in these.
    - `uses_volume`: friction depends on the volume, whatever the model's law.
    - `limits_speed`: it holds the speed on any steep and long path, as friction alone does not.
    - `nuisance(columns, sites)`: of one that the diagnosis grants before it blames anything on
      physics, what the data lack for that, which may be less than for its name.
    - `granted_unasked`: it is granted even where the records do not ask for it.
    - `level_alone`: the level at which the diagnosis tests it by itself, always fitted in full, as
      it has no score at neutral; None where it is screened.
    - `says_what_is_seen`: it is about which avalanches were recorded at all. What the diagnosis
      finds on the motion must hold beside it.
    - `alternatives(columns, sites)`: other facts, such as dates, of which `facts` is the likeliest.
    - `beyond`: 0 for the catalogue, 1 for a kind that is made for what a file has, 2 for pairs of
      these. Of effects that explain alike the lowest is named; `family` is the kind's name.
    - `curve(facts)`: of an effect that is a smooth curve, that; None where it has levels.
    - `member_of`: the key of a smooth of which it is one shape, and that shape as a function of its
      values and the states; where either stands out both are fitted, the smooth from that shape on.
    - `names_cause`: False for a smooth curve: a verdict on such alone is `unexplained`.
    - `column`: the column that the effect is about; a smooth of it would only repeat the effect.
    - `reads`: the column of numbers that it goes by where a smooth of that is another effect.
    - `already_stated(columns, sites)`: whether the data state what it would estimate, so that it is
      no candidate.
    - `seen_in(columns, sites)`: where the records have what the effect is about, in a sentence.
    - `order`: its place in the list; equal ones stand by key.
    - `text`: the effect file that makes it, if it is a user's own.
    """

    key: str
    meaning: str
    needs: str
    build: Callable[[Facts], Effect]
    lacking: Answer = lambda _columns, _sites: None
    facts: Callable[[EventColumns, Sites], Facts] = lambda _columns, _sites: {}
    changes: Setting | None = None
    event_columns: bool = False
    uses_volume: bool = False
    limits_speed: bool = False
    nuisance: Answer | None = None
    granted_unasked: bool = False
    level_alone: float | None = None
    says_what_is_seen: bool = False
    alternatives: Callable[[EventColumns, Sites], Sequence[Facts]] | None = None
    beyond: int = 0
    curve: Callable[[Facts], Curve | None] = lambda _facts: None
    member_of: tuple[str, Callable[[Floats, Floats], Floats]] | None = None
    names_cause: bool = True
    column: str | None = None
    reads: str | None = None
    already_stated: Callable[[EventColumns, Sites], bool] = lambda _columns, _sites: False
    seen_in: Answer = lambda _columns, _sites: None
    order: int = 1000
    text: str = ""

    @property
    def family(self) -> str:
        """The kind that it is one of many of, or its key."""
        return self.key.partition(":")[0] if self.beyond else self.key

    @property
    def in_base(self) -> bool:
        """Whether the base model has it, so that `--without` can leave it out."""
        return self.changes is not None and self.changes.without is not None
