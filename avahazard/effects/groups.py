"""Groups of events that share an offset of log friction: those of a path, a winter, a storm.

Each effect has one parameter, the spread of these offsets. And two kinds of avalanche that nobody
recorded: friction scatters about two places.
"""

from collections.abc import Callable, Sequence
from datetime import date
from functools import partial

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    Definition,
    Facts,
    FrictionEffect,
    GroupEffect,
    Groups,
    KindsEffect,
    Parameter,
    Sites,
    fewest_events,
    known,
    unless,
)

SPREAD = 0.2
"""Scale of the half-normal prior, on log friction. The seven paths of Ancey (2005), whose log a
differs with a standard deviation of 0.09, lie in its middle half."""

MIN_PATHS = 5
"""Fewest paths that tell their spread well enough for it to be named or added."""
MIN_SHARED = 5
"""Fewest groups of two events or more that tell their spread from the scatter of events."""
DAYS = 3
"""A storm is what falls within so many days of its first avalanche, on the paths of one location.
It is counted from the first, not from one to the next, or a busy winter would be one storm."""


def _spread(name: str) -> tuple[Parameter, ...]:
    """The spread τ between groups; `name` is its own among all spreads."""
    return (Parameter(name, "log friction", 0.0, 0.0, SPREAD, 0.0),)


PATH = "path:"
OFFSET_SD = 0.2
"""Prior standard deviation of the log friction of one path against the others'."""


def one_path(path: str) -> Definition:
    """The effect of one path that differs, where paths are too few for a spread between them."""
    return Definition(
        key=PATH + path,
        meaning=f"Friction on path {path} differs from that on the others, for a reason that no "
        f"column records. Where there are {MIN_PATHS} paths or more, path-effect is asked.",
        needs="events on the path, and on others",
        build=partial(_build_path, path),
        lacking=partial(_lacking_path, path),
        beyond=1,
        names_cause=False,
    )


def _build_path(path: str, _facts: Facts) -> FrictionEffect:
    def design(columns: EventColumns) -> Floats:
        return columns.on_path(path)[:, None].astype(np.float64)

    parameter = Parameter("offset", "log friction", 0.0, 0.0, OFFSET_SD)
    return FrictionEffect(PATH + path, (parameter,), design, paths=(path,))


def _lacking_path(path: str, columns: EventColumns, _sites: Sites) -> str | None:
    n = int(np.sum(columns.on_path(path)))
    return None if 0 < n < len(columns) else f"{n} of {len(columns)} events are on path {path}"


def _by_path(columns: EventColumns) -> Groups:
    return Groups(columns.paths, columns.path_index, told=PATH)


def _n_paths(columns: EventColumns) -> int:
    return len(np.unique(columns.path_index[columns.path_index >= 0]))


def _few_paths(columns: EventColumns, _sites: Sites) -> str | None:
    n = _n_paths(columns)
    return None if n >= MIN_PATHS else f"there are {n} paths, fewer than {MIN_PATHS}"


PATH_EFFECT = Definition(
    key="path-effect",
    meaning="Each path has a friction of its own, for a reason that no column records (roughness, "
    "exposure, climate). Its spread between paths is τ, on log friction.",
    needs=f">= {MIN_PATHS} paths",
    build=lambda _: GroupEffect("path-effect", _spread("tau"), _by_path),
    lacking=_few_paths,
    nuisance=unless(lambda columns: _n_paths(columns) > 1, "there is one path"),
    granted_unasked=True,
    order=130,
)


def _winter_labels(columns: EventColumns) -> list[str]:
    return ["" if np.isnan(year) else f"winter:{year:.0f}" for year in columns.winter]


def _winters(columns: EventColumns, _sites: Sites) -> Facts:
    """Winters of two events or more, sorted."""
    labels = [label for label in _winter_labels(columns) if label]
    names, counts = np.unique(labels, return_counts=True)
    return {"winters": [str(name) for name in names[counts > 1]]}


def _few_winters(columns: EventColumns, sites: Sites) -> str | None:
    if len(_winters(columns, sites)["winters"]) >= MIN_SHARED:
        return None
    return f"fewer than {MIN_SHARED} winters have two events or more"


def _temporary(
    key: str, tau: str, names: Sequence[str], labels: Callable[[EventColumns], list[str]]
) -> GroupEffect:
    """The effect of groups that do not come again; `labels` gives each event its name, or none."""

    def groups(columns: EventColumns) -> Groups:
        place = {name: k for k, name in enumerate(names)}
        index = [place.get(label, -1) for label in labels(columns)]
        return Groups(tuple(names), np.array(index, dtype=np.int64), alone=True)

    return GroupEffect(key, _spread(tau), groups)


WINTER_EFFECT = Definition(
    key="winter-effect",
    meaning="Avalanches of one winter (October to September) share something that no column "
    "records, such as its weather or its observer. The spread between winters is τ, on log "
    "friction.",
    needs="date",
    build=lambda facts: _temporary("winter-effect", "tau_winter", facts["winters"], _winter_labels),
    lacking=_few_winters,
    facts=_winters,
    nuisance=_few_winters,
    order=132,
)


def _storms(columns: EventColumns, _sites: Sites) -> Facts:
    """Location and ordinal of the first day of each storm of two events or more."""
    found: list[list[object]] = []
    for place in np.unique(columns.location):
        days = np.sort(known(columns.day[columns.location == place]))
        while len(days):
            within = days <= days[0] + DAYS
            if np.sum(within) > 1:
                found.append([str(place), int(days[0])])
            days = days[~within]
    return {"storms": found}


def _few_storms(columns: EventColumns, sites: Sites) -> str | None:
    if len(_storms(columns, sites)["storms"]) >= MIN_SHARED:
        return None
    return f"fewer than {MIN_SHARED} times did two avalanches fall within {DAYS} days"


def _storm_name(place: str, day: int) -> str:
    return f"storm:{date.fromordinal(day).isoformat()} {place}".strip()


def _storm_effect(facts: Facts) -> GroupEffect:
    storms = [(str(place), int(day)) for place, day in facts["storms"]]
    named = {
        (place, day + k): _storm_name(place, day) for place, day in storms for k in range(DAYS + 1)
    }

    def labels(columns: EventColumns) -> list[str]:
        places = zip(columns.location, np.nan_to_num(columns.day, nan=-1.0), strict=True)
        return [named.get((str(place), int(day)), "") for place, day in places]

    names = [_storm_name(*storm) for storm in storms]
    return _temporary("storm-effect", "tau_storm", names, labels)


STORM_EFFECT = Definition(
    key="storm-effect",
    meaning=f"Avalanches that fall within {DAYS} days at one location share their snow, in a way "
    "that no column records. The spread between storms is τ, on log friction.",
    needs="date",
    build=_storm_effect,
    lacking=_few_storms,
    facts=_storms,
    nuisance=_few_storms,
    order=134,
)


FEWEST_OF_KINDS = 30
"""Fewest events that can tell two kinds from one."""
RAREST = 0.15
"""Share of the rarer kind, at least: what is rarer passes for heavy tails or wrong records."""
KINDS_LEVEL = 0.005
"""Level at which the diagnosis tests two kinds."""
SHIFT_SD = 0.3
"""Prior standard deviation of the shift, that of the friction of wet snow against dry."""
OF_KINDS = (
    Parameter("share", "of the avalanches", 0.5, 0.5, 0.3, RAREST, 1.0 - RAREST),
    Parameter("shift", "log friction", 0.0, 0.0, SHIFT_SD, -1.5, 0.0),
)


TWO_KINDS = Definition(
    key="two-kinds",
    meaning="Avalanches are of two kinds that no column records. Friction is a mixture: the log "
    "friction of a share of them lies lower than that of the others, and the mean of both follows "
    "the law.",
    needs=f"{FEWEST_OF_KINDS} events",
    build=lambda _: KindsEffect("two-kinds", OF_KINDS),
    lacking=fewest_events(FEWEST_OF_KINDS),
    level_alone=KINDS_LEVEL,
    order=142,
)
