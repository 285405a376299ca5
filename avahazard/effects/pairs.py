"""What one column does depends on another: their product, or a change beyond limits of both."""

from collections.abc import Sequence
from functools import partial
from itertools import product

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns, friction_by_paths
from avahazard.effects.covariate import (
    LEAST_SD,
    LINEAR_SD,
    MIN_EVENTS,
    VOLUME,
    design_of,
    known_numbers,
    level_counts,
    level_facts,
    level_lacking,
    line_of,
    text_column,
)
from avahazard.effects.effect import MIN_LEVEL, Definition, Facts, FrictionEffect, Parameter, Sites
from avahazard.notes import Note

INTERACTION = "interaction:"
MOST_LEVELS = 4
"""Levels of a column that are distinguished beside another."""
LIMITS, FINE_LIMITS = (0.3, 0.5, 0.7), tuple(k / 20 for k in range(1, 20))
"""Shares of the events under limits of a number that are screened, and that one is chosen from."""
SHARPER = 3.0
"""Nats by which a region must lead a product: a sharp limit is the stronger claim."""
REGION = "log friction there"
"""Unit of what friction changes by where two columns are beyond their limits."""


def other_way(key: str) -> str:
    """The key of a pair with its columns the other way round; any other key as it is."""
    return INTERACTION + "*".join(names[::-1]) if (names := columns_of_pair(key)) else key


def columns_of_pair(key: str) -> list[str]:
    """The columns of the key of a pair; none of any other."""
    return key.removeprefix(INTERACTION).split("*") if key.startswith(INTERACTION) else []


def interaction(pair: str) -> Definition:
    """The effect of `A*B`, two columns, the second perhaps `volume_m3`."""
    one, _, other = pair.partition("*")
    return Definition(
        key=INTERACTION + pair,
        meaning=f"What {one} does to friction depends on {other}: it matters for some avalanches "
        "and not for others. Both columns and their product are fitted, or one change where both "
        "are beyond a limit.",
        needs=f"columns {one} and {other}",
        build=partial(_build_pair, one, other),
        lacking=partial(_lacking_pair, one, other),
        facts=partial(_likeliest_pair, one, other),
        alternatives=partial(_ways_of_pair, one, other),
        seen_in=partial(_region_seen, one, other),
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
    """Of each column its levels, or centre and spread; left out where it has no information."""
    found: Facts = {}
    for name in (one, other):
        line = line_of(columns, name)
        if line is not None:
            found[name] = line
        elif level_lacking(name, columns) is None:
            found[name] = {"levels": level_facts(name, columns, most=MOST_LEVELS)["levels"]}
    return found


def _regions(
    one: str, other: str, columns: EventColumns, shares: Sequence[float]
) -> tuple[list[Facts], Floats]:
    """Every region of two columns with enough events in it and beside it.

    And columns `[n_events, n_regions]`: 1 in it, else 0. Limits of numbers are at these `shares`.
    """
    sides = []
    for name in (one, other):
        if line_of(columns, name) is None:
            found = text_column(columns, name)
            assert found is not None
            common = [k for k, n in level_counts(found).items() if n >= MIN_LEVEL]
            limits: list[Facts] = [{"levels": [k]} for k in common]
        else:
            at = np.unique(np.quantile(known_numbers(columns, name), shares)).tolist()
            limits = [{side: limit} for side in ("over", "under") for limit in at]
        design = [design_of(name, limit, columns) for limit in limits]
        sides.append((limits, np.hstack([np.empty((len(columns), 0)), *design])))
    (first, a), (second, b) = sides
    inside = a.T @ b
    beside = np.minimum(a.sum(axis=0)[:, None] - inside, b.sum(axis=0) - inside)
    kept = np.argwhere(np.minimum(inside, beside) >= 2 * MIN_LEVEL)
    facts = [{one: first[k], other: second[m], "region": True} for k, m in kept]
    return facts, a[:, kept[:, 0]] * b[:, kept[:, 1]]


def _ways_of_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> list[Facts]:
    """The columns with their product, then regions."""
    return [_facts_pair(one, other, columns, sites), *_regions(one, other, columns, LIMITS)[0]]


def _likeliest_pair(one: str, other: str, columns: EventColumns, sites: Sites) -> Facts:
    """The way that explains H/L best, volume and path taken off (least squares, with its price).

    Where that is a region, with the best of finer limits.
    """
    both = _facts_pair(one, other, columns, sites)
    use, ratio, rest = friction_by_paths(columns)
    regions, there = _regions(one, other, columns, FINE_LIMITS)
    if not regions or len(ratio) < rest.shape[1] + MIN_EVENTS:
        return both

    def left(values: Floats) -> Floats:
        return np.asarray(values - basis @ (basis.T @ values))

    basis = np.linalg.qr(rest)[0]
    ratio, design = left(ratio), left(_build_pair(one, other, both).design(columns)[use])
    there = left(there[use])
    explained = (ratio @ there) ** 2 / np.maximum(np.sum(there**2, axis=0), 1e-9)
    best = int(np.argmax(explained))
    beside = ratio - design @ np.linalg.lstsq(design, ratio, rcond=None)[0]
    lead = 0.5 * len(ratio) * np.log((beside @ beside) / (ratio @ ratio - explained[best]))
    lead += 0.5 * np.log(len(ratio)) * (design.shape[1] - 1)
    return regions[best] if lead > np.log(len(regions)) + SHARPER else both


def _region_seen(one: str, other: str, columns: EventColumns, sites: Sites) -> Note | None:
    if _lacking_pair(one, other, columns, sites):
        return None
    facts = _likeliest_pair(one, other, columns, sites)
    if "region" not in facts:
        return None
    there = _build_pair(one, other, facts).design(columns)
    names = [_label(name, facts[name]) for name in (one, other)]
    return Note("region", names=names, n=int(np.sum(there)), events=len(columns))


def _label(name: str, facts: Facts) -> str:
    """A column with its level or limit, as a parameter is named."""
    if "levels" in facts:
        return f"{name}={facts['levels'][0]}"
    (side, limit), *_ = facts.items()
    value = np.exp(limit) if name == VOLUME else limit
    return f"{name}{'>' if side == 'over' else '<'}{value:.4g}"


def _products(first: Floats, second: Floats) -> Floats:
    return np.asarray((first[:, :, None] * second[:, None, :]).reshape(len(first), -1))


def _build_pair(one: str, other: str, facts: Facts) -> FrictionEffect:
    region = "region" in facts
    alone = [name for name in (one, other) if name != VOLUME and not region]

    def design(columns: EventColumns) -> Floats:
        parts = {name: design_of(name, facts[name], columns) for name in (one, other)}
        return np.column_stack(
            [*(parts[name] for name in alone), _products(parts[one], parts[other])]
        )

    def labels(name: str) -> list[str]:
        levels = facts[name].get("levels")
        return [name] if levels is None else [f"{name}={level}" for level in levels]

    def parameters(*names: str) -> list[Parameter]:
        sd = LEAST_SD if any("levels" in facts[name] for name in names) else LINEAR_SD
        every = product(*map(labels, names))
        return [Parameter("*".join(some), "log friction", 0.0, 0.0, sd) for some in every]

    each = [parameter for name in alone for parameter in parameters(name)]
    both = parameters(one, other)
    if region:
        name = "*".join(_label(name, facts[name]) for name in (one, other))
        both = [Parameter(name, REGION, 0.0, 0.0, LEAST_SD)]
    key = f"{INTERACTION}{one}*{other}"
    return FrictionEffect(key, (*each, *both), design=design)
