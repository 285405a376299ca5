"""What one column does depends on another.

By their product, a change beyond limits of both, or a line in one beyond a limit of the other. Or
on the path: one column acts on some of them.
"""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns, friction_by_paths, where_it_acts
from avahazard.effects.covariate import (
    LEAST_SD,
    LINEAR_SD,
    MIN_EVENTS,
    PATH_ID,
    VOLUME,
    bends_of,
    design_of,
    known_numbers,
    level_counts,
    level_facts,
    level_lacking,
    line_of,
    smooth_of,
    text_column,
)
from avahazard.effects.effect import MIN_LEVEL, Definition, Facts, FrictionEffect, Parameter, Sites
from avahazard.notes import Note

INTERACTION = "interaction:"
MOST_LEVELS = 4
"""Levels of a column that are distinguished beside another."""
LIMITS, FINE_LIMITS = (0.3, 0.5, 0.7), tuple(k / 20 for k in range(1, 20))
"""Shares of the events under limits of a number that are screened, and between which one is."""
NEAREST = 15
"""Values on either side of such a limit between which the final one is."""
SHARPER = 3.0
"""Nats by which a region must lead a product, the weaker claim, and a limit of one column alone."""
LEAST_ALONG = 0.1
"""Least variance of a line's column in a region, over that of all events."""
THERE, PER_SD = "log friction there", "log friction per sd there"
"""Units of what friction changes by where columns are beyond their limits."""


def other_way(key: str) -> str:
    """The key of a pair with its columns the other way round; any other key as it is."""
    return INTERACTION + "*".join(names[::-1]) if (names := columns_of_pair(key)) else key


def columns_of_pair(key: str) -> list[str]:
    """The columns of the key of a pair; none of any other."""
    return key.removeprefix(INTERACTION).split("*") if key.startswith(INTERACTION) else []


def interaction(pair: str) -> Definition:
    """The effect of `A*B`, two columns, the second perhaps `volume_m3` or `path_id`."""
    one, _, other = pair.partition("*")
    if other == PATH_ID:
        fitted = f"the paths. Fitted is {one} by itself on each path where it matters."
    else:
        fitted = (
            f"{other}: it matters for some avalanches and not for others. Fitted are both columns "
            "and their product, a change where both are beyond a limit, or a line in one column "
            "beyond a limit of the other."
        )
    return Definition(
        key=INTERACTION + pair,
        meaning=f"What {one} does to friction depends on {fitted}",
        needs=f"columns {one} and {other}",
        build=partial(_build_pair, one, other),
        lacking=partial(_lacking_pair, one, other),
        facts=partial(_likeliest_pair, one, other),
        alternatives=partial(_ways_of_pair, one, other),
        seen_in=partial(_seen_in, one, other),
        event_columns=True,
        uses_volume=VOLUME in (one, other),
        beyond=2,
    )


def _lacking_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> str | None:
    facts = _facts_pair(one, other, columns, sites)
    for name in (one, other):
        if name not in facts:
            return f"{name} has no two values with at least {MIN_LEVEL} events each"
    first, second = (design_of(name, facts[name], columns) for name in (one, other))
    both = _products(first, second)
    alone = np.column_stack([np.ones(len(columns)), first, second])
    both -= alone @ np.linalg.lstsq(alone, both, rcond=None)[0]
    if np.sum(np.any(np.abs(both) > 1e-6, axis=1)) < 4 * MIN_LEVEL:
        return f"{one} and {other} do not vary apart from each other"
    return None


def _facts_pair(one: str, other: str, columns: EventColumns, _sites: Sites) -> Facts:
    """Of each column its levels, or a line; left out where it has no information.

    Of numbers beside levels of texts a smooth: they may matter beyond a limit that is soft.
    """
    found: Facts = {}
    lines = [line_of(columns, name) for name in (one, other)]
    by_level = lines.count(None) == 1 and other != PATH_ID
    for name in (one, other):
        line = smooth_of(columns, name) if by_level else line_of(columns, name)
        if line is not None:
            found[name] = line
        elif level_lacking(name, columns) is None:
            most_common = level_facts(name, columns, most=MOST_LEVELS)["levels"]
            found[name] = {"levels": _common(name, columns) if name == PATH_ID else most_common}
    return found


def _common(name: str, columns: EventColumns) -> list[str]:
    """Levels of a column of texts with enough events."""
    texts = text_column(columns, name)
    assert texts is not None
    return [k for k, n in level_counts(texts).items() if n >= MIN_LEVEL]


Limits = Callable[[str], Floats]
"""Limits of a column of numbers by its name."""


def _at_shares(shares: Sequence[float], columns: EventColumns) -> Limits:
    """Limits under which these shares of the events are."""
    return lambda name: np.unique(np.quantile(known_numbers(columns, name), shares))


def _near(facts: Facts, columns: EventColumns) -> Limits:
    """Limits between any two values near those of a region."""

    def near(name: str) -> Floats:
        here = facts[name].get("over", facts[name].get("under"))
        if here is None:
            return np.empty(0)
        values = np.unique(known_numbers(columns, name))
        k = int(np.searchsorted(values, here))
        nearest = values[max(k - NEAREST, 0) : k + NEAREST]
        return np.asarray(0.5 * (nearest[:-1] + nearest[1:]))

    return near


def _regions(
    one: str, other: str, columns: EventColumns, limits: Limits
) -> tuple[list[Facts], Floats, Floats, Floats]:
    """Every region of two columns, or of one, with enough events in it and beside it.

    And columns `[n_events, n_regions]`: 1 in it, else 0; of the last, which are of one column, the
    line in the other one there `[n_events, n_lines]`; and 1 beyond each limit of either column.
    """
    sides, lines = [], []
    for name in (one, other):
        line = line_of(columns, name)
        if line is None:
            bounds: list[Facts] = [{"levels": [k]} for k in _common(name, columns)]
        else:
            at = limits(name).tolist()
            bounds = [{side: limit} for side in ("over", "under") for limit in at]
        design = [design_of(name, bound, columns) for bound in bounds]
        sides.append((bounds, np.hstack([np.empty((len(columns), 0)), *design])))
        lines.append(line)
    (first, a), (second, b) = sides
    inside = a.T @ b
    beside = np.minimum(a.sum(axis=0)[:, None] - inside, b.sum(axis=0) - inside)
    kept = np.argwhere(np.minimum(inside, beside) >= 2 * MIN_LEVEL)
    facts: list[Facts] = [{one: first[k], other: second[m], "region": True} for k, m in kept]
    there, along = [a[:, kept[:, 0]] * b[:, kept[:, 1]]], [np.empty((len(columns), 0))]
    for name, line, beyond, (bounds, within) in zip(
        (one, other), lines, (other, one), sides[::-1], strict=True
    ):
        if line is None:
            continue
        run = within * design_of(name, line, columns)
        n = within.sum(axis=0)
        varies = np.sum(run**2, axis=0) - np.sum(run, axis=0) ** 2 / np.maximum(n, 1.0)
        enough = (np.minimum(n, len(columns) - n) >= 2 * MIN_LEVEL) & (varies > LEAST_ALONG * n)
        wide = np.flatnonzero(enough)
        facts += [{name: line, beyond: bounds[k], "region": True, "line": True} for k in wide]
        there.append(within[:, wide])
        along.append(run[:, wide])
    return facts, np.hstack(there), np.hstack(along), np.hstack([a, b])


def _ways_of_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> list[Facts]:
    """The columns with their product, then regions; or one column on every path."""
    if other == PATH_ID:
        return [_facts_pair(one, other, columns, sites)]
    regions, *_ = _regions(one, other, columns, _at_shares(LIMITS, columns))
    return [_facts_pair(one, other, columns, sites), *regions]


class _Best(NamedTuple):
    """Of the best of `n` regions its gain (nats) and facts; the gain of the best limit alone."""

    gain: float
    facts: Facts
    alone: float
    n: int


def _likeliest_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> Facts:
    """The way that explains H/L best, volume and path taken off (least squares, with its price).

    Where that is a region, with the best of the finest limits. Of a column that acts by path, on
    those paths where it matters.
    """
    both = _facts_pair(one, other, columns, sites)
    use, ratio, rest = friction_by_paths(columns)
    if len(ratio) < rest.shape[1] + MIN_EVENTS:
        return both
    basis = np.linalg.qr(rest)[0]

    def left(values: Floats) -> Floats:
        return np.asarray(values - basis @ (basis.T @ values))

    ratio = left(ratio)

    def nats(left_over: Floats, n: int) -> Floats:
        fit = np.log(np.maximum(left_over, 1e-12))
        return np.asarray(-0.5 * len(ratio) * fit - 0.5 * np.log(len(ratio)) * n)

    def by_product(facts: Facts) -> float:
        design = left(_build_pair(one, other, facts).design(columns)[use])
        beside = ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]
        return float(nats(beside @ beside, design.shape[1]))

    if other == PATH_ID:
        paths = both[other]["levels"]
        on = where_it_acts(paths, lambda some: by_product({**both, other: {"levels": some}}))
        return {**both, other: {"levels": on}}

    def explains(values: Floats) -> Floats:
        return np.asarray((ratio @ values) ** 2 / np.maximum(np.sum(values**2, axis=0), 1e-9))

    def best_of(limits: Limits) -> _Best:
        facts, there, along, alone = _regions(one, other, columns, limits)
        if not facts:
            return _Best(-np.inf, both, -np.inf, 1)
        there, along, alone = left(there[use]), left(along[use]), left(alone[use])
        of_step, n, all_of_it = explains(there), there.shape[1] - along.shape[1], ratio @ ratio
        last = there[:, n:]
        size = np.maximum(np.sum(last**2, axis=0), 1e-9)
        of_line = of_step[n:] + explains(along - last * np.sum(last * along, axis=0) / size)
        gains = np.append(nats(all_of_it - of_step[:n], 1), nats(all_of_it - of_line, 2))
        best, by_one = int(np.argmax(gains)), np.max(nats(all_of_it - explains(alone), 1))
        return _Best(float(gains[best]), facts[best], float(by_one), len(facts))

    coarse = best_of(_at_shares(FINE_LIMITS, columns))
    fine = best_of(_near(coarse.facts, columns)) if coarse.facts is not both else coarse
    best = max(coarse, fine, key=lambda found: found.gain)
    simpler = max(by_product(both), coarse.alone, fine.alone)
    return best.facts if best.gain - simpler > np.log(coarse.n) + SHARPER else both


def _seen_in(one: str, other: str, columns: EventColumns, sites: Sites) -> Note | None:
    if _lacking_pair(one, other, columns, sites):
        return None
    facts = _likeliest_pair(one, other, columns, sites)
    if other == PATH_ID:
        return Note("on_paths", column=one, paths=facts[other]["levels"])
    if "region" not in facts:
        return None
    n = int(np.sum(_build_pair(one, other, facts).design(columns)[:, 0]))
    lines, limits = _lines_and_limits(one, other, facts)
    names = [_label(name, facts[name]) for name in limits]
    if lines:
        return Note("line_in_region", column=lines[0], names=names, n=n, events=len(columns))
    return Note("region", names=names, n=n, events=len(columns))


def _label(name: str, facts: Facts) -> str:
    """A column with its level or limit, as a parameter is named."""
    if "levels" in facts:
        return f"{name}={facts['levels'][0]}"
    (side, limit), *_ = facts.items()
    value = np.exp(limit) if name == VOLUME else limit
    return f"{name}{'>' if side == 'over' else '<'}{value:.4g}"


def _products(first: Floats, second: Floats) -> Floats:
    return np.asarray((first[:, :, None] * second[:, None, :]).reshape(len(first), -1))


def _lines_and_limits(one: str, other: str, facts: Facts) -> tuple[list[str], list[str]]:
    """Of a region the column that acts by a line there, if any, and those that bound it."""
    lines = [name for name in (one, other) if "centre" in facts[name]]
    return lines, [name for name in (one, other) if name not in lines]


def _build_region(one: str, other: str, facts: Facts) -> FrictionEffect:
    lines, limits = _lines_and_limits(one, other, facts)

    def design(columns: EventColumns) -> Floats:
        there = np.prod([design_of(name, facts[name], columns) for name in limits], axis=0)
        return np.hstack(
            [there, *(there * design_of(name, facts[name], columns) for name in lines)]
        )

    label = "*".join(_label(name, facts[name]) for name in limits)
    along = [Parameter(f"{name}*{label}", PER_SD, 0.0, 0.0, LINEAR_SD) for name in lines]
    parameters = (Parameter(label, THERE, 0.0, 0.0, LEAST_SD), *along)
    return FrictionEffect(f"{INTERACTION}{one}*{other}", parameters, design=design)


def _build_pair(one: str, other: str, facts: Facts) -> FrictionEffect:
    if "region" in facts:
        return _build_region(one, other, facts)
    alone = [] if other == PATH_ID else [name for name in (one, other) if name != VOLUME]

    def design(columns: EventColumns) -> Floats:
        parts = {name: design_of(name, facts[name], columns) for name in (one, other)}
        return np.column_stack(
            [*(parts[name] for name in alone), _products(parts[one], parts[other])]
        )

    def labels(name: str) -> list[tuple[str, float]]:
        levels = facts[name].get("levels")
        if levels is not None:
            return [(f"{name}={level}", LEAST_SD) for level in levels]
        bends = [(f"{name}.{bend}", sd) for bend, sd in bends_of(facts[name])]
        return [(name, LINEAR_SD), *bends]

    def parameters(*names: str) -> list[Parameter]:
        made = [zip(*some, strict=True) for some in product(*map(labels, names))]
        return [Parameter("*".join(n), "log friction", 0.0, 0.0, min(sd)) for n, sd in made]

    each = [parameter for name in alone for parameter in parameters(name)]
    key, both = f"{INTERACTION}{one}*{other}", parameters(one, other)
    # The paths of the parameters, which turn fastest.
    paths = facts[other]["levels"] * len(labels(one)) if other == PATH_ID else []
    return FrictionEffect(key, (*each, *both), design=design, paths=tuple(paths))
