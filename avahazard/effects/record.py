"""Effects on the record: shifts, fronts, undetected runouts, and stated errors."""

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import (
    MIN_LEVEL,
    Definition,
    Facts,
    FrontEffect,
    LimitEffect,
    Parameter,
    RecordErrorEffect,
    ShiftEffect,
    Sites,
    VolumeErrorEffect,
    fewest_events,
    known,
    needs_profile,
    unless,
)

SHIFT = Parameter("shift", "m", 0.0, 0.0, 40.0, -160.0, 160.0)
EDGE_YEARS = 4.0
"""The change is blurred over these years, so that the likelihood is smooth in its date."""
DETECTION_LEVEL = 0.003
"""Level at which the diagnosis tests a limit that is estimated."""


def _shift(columns: EventColumns, values: Floats) -> Floats:
    shift, year = values
    before = np.clip((year - columns.year) / EDGE_YEARS + 0.5, 0.0, 1.0)
    return np.asarray(shift * np.nan_to_num(before))


def _years(columns: EventColumns, _sites: Sites) -> Facts:
    years = np.quantile(known(columns.year), np.linspace(0.1, 0.9, 9)).round()
    return {"years": np.unique(years).tolist()}


def _epoch_bias(facts: Facts) -> ShiftEffect:
    years = facts["years"]
    middle = years[len(years) // 2]
    before = Parameter("before", "year", middle, middle, 50.0, years[0], years[-1])
    return ShiftEffect("epoch-bias", (SHIFT, before), shift=_shift)


EPOCH_BIAS = Definition(
    key="epoch-bias",
    meaning="Old records were made differently (from hearsay, from the valley, to the reach of "
    "the powder). Before some year they lie systematically too high or too low; volumes that were "
    "estimated otherwise before it look alike.",
    needs="date",
    build=_epoch_bias,
    lacking=unless(
        lambda columns: (
            len(known(columns.year)) >= 4 * MIN_LEVEL and np.ptp(known(columns.year)) >= 20
        ),
        "fewer than 20 dated events over 20 years",
    ),
    facts=_years,
    order=150,
)


SHARE = Parameter("share", "of the deposit length", 0.0, 0.5, 0.5, 0.0, 1.5)
LEADING_EDGE = Definition(
    key="leading-edge",
    meaning="What is written down is where the front came to lie, while the block is the centre "
    "of mass. The front is ahead by a share of the deposit's length (about a half).",
    needs="deposit length",
    build=lambda _: FrontEffect(
        "leading-edge", (SHARE,), lambda columns, v: v[0] * np.nan_to_num(columns.deposit_length)
    ),
    lacking=unless(
        lambda columns: len(known(columns.deposit_length)) >= 10,
        "fewer than 10 events have a deposit length",
    ),
    event_columns=True,
    reads="deposit_length_m",
    order=160,
)


FAR_M = 1000.0
"""A limit this far above the highest stop seen is no limit."""


def _highest_stops(columns: EventColumns, sites: Sites) -> Facts:
    highest = {}
    for k, site in enumerate(sites):
        on = columns.path_index == k
        by_x = site.smooth.height(known(columns.stop_x[on]))
        stops = np.concatenate([known(columns.stop_elevation[on]), by_x])
        declared = site.path.observed_below_m
        if declared is not None:
            highest[site.path.path_id] = {"declared_m": declared}
        elif len(stops):
            highest[site.path.path_id] = {"highest_m": float(np.max(stops))}
    return {"paths": highest}


def _declared(columns: EventColumns, sites: Sites) -> list[bool]:
    """Of each path with events, whether a limit is declared."""
    with_events = np.unique(columns.path_index[columns.path_index >= 0])
    return [sites[k].path.observed_below_m is not None for k in with_events]


def _few_stops(columns: EventColumns, sites: Sites) -> str | None:
    if any(_declared(columns, sites)):
        return None
    # The highest of very few stops is where these stopped, and no limit.
    stops = columns.path_index[np.isfinite(columns.stop_elevation)]
    if np.max(np.bincount(stops[stops >= 0], minlength=1)) >= MIN_LEVEL:
        return None
    lack = f"no path has {MIN_LEVEL} stops with an elevation, or a declared limit"
    return needs_profile(columns, sites) or lack


def _limit(facts: Facts) -> LimitEffect:
    paths: dict[str, dict[str, float]] = facts["paths"]

    def limit(columns: EventColumns, values: Floats) -> Floats:
        result = np.full(len(columns), np.nan)
        for i, k in enumerate(columns.path_index):
            of_path = paths.get(columns.paths[k], {}) if k >= 0 else {}
            if "declared_m" in of_path:
                result[i] = of_path["declared_m"]
            elif "highest_m" in of_path and values[0] < FAR_M:
                result[i] = of_path["highest_m"] + values[0]
        return result

    margin = Parameter("margin", "m above the highest stop seen", FAR_M, 200.0, 400.0, 0.0, FAR_M)
    return LimitEffect("observation-limit", (margin,), limit=limit)


OBSERVATION_LIMIT = Definition(
    key="observation-limit",
    meaning="Only avalanches that came low enough were seen and written down. The many short "
    "ones are missing, so friction looks lower than it is; the likelihood is divided by the "
    "chance to be seen.",
    needs="observed_below_m, or estimated",
    build=_limit,
    lacking=_few_stops,
    facts=_highest_stops,
    already_stated=lambda columns, sites: all(_declared(columns, sites)),
    level_alone=DETECTION_LEVEL,
    says_what_is_seen=True,
    order=140,
)


PRIOR_SD = float(np.log(2.0))
"""Errors are stated by judgement; that they are off by two either way is common, by four rare."""
MOST = float(np.log(8.0))
MIN_SPREAD = 0.1
"""Smallest natural spread of log volume that is believed."""


def _log_factor(high: float = MOST) -> tuple[Parameter, ...]:
    """The log of the factor, none of it (0) being what is stated."""
    return (Parameter("log_factor", "log of the factor", 0.0, 0.0, PRIOR_SD, -MOST, high),)


RECORD_ERROR = Definition(
    key="record-error",
    meaning="The stated errors of the records are too small or too large, all by one factor. "
    "Such an error moves the friction that a record asks for more on some ground than on other, "
    "natural scatter does so alike, so the two can be distinguished.",
    needs=f"{4 * MIN_LEVEL} events",
    build=lambda _: RecordErrorEffect("record-error", _log_factor()),
    lacking=fewest_events(4 * MIN_LEVEL),
    order=164,
)


def variance_within(groups: Sequence[Floats]) -> float:
    """Variance of values about the mean of their group, one degree of freedom a group."""
    groups = [values for values in groups if len(values)]
    squares = sum(float(np.sum((values - np.mean(values)) ** 2)) for values in groups)
    return squares / max(1, sum(len(values) for values in groups) - len(groups))


def largest_factor(columns: EventColumns) -> float:
    """The factor on stated errors of volumes that explains all their scatter; inf without any."""
    stated = columns.volume_error[np.isfinite(columns.log_volume)]
    stated2 = float(np.mean(stated**2)) if len(stated) else 0.0
    if stated2 == 0.0:
        return np.inf
    paths = range(-1, len(columns.paths))
    total2 = variance_within([known(columns.log_volume[columns.path_index == k]) for k in paths])
    return float(np.sqrt(max(total2 - MIN_SPREAD**2, 0.0) / stated2))


def _few_volumes(columns: EventColumns, _sites: Sites) -> str | None:
    volumes = known(columns.log_volume)
    if len(volumes) < 4 * MIN_LEVEL or np.ptp(volumes) == 0.0:
        return f"fewer than {4 * MIN_LEVEL} events have (different) volumes"
    exact = not np.any(columns.volume_error[np.isfinite(columns.log_volume)] > 0.0)
    return "the volumes are stated to be exact" if exact else None


VOLUME_ERROR = Definition(
    key="volume-error",
    meaning="The stated errors of the volumes are too small or too large, all by one factor. "
    "Friction then scatters most where the law is steepest in volume, and bends towards its mean.",
    needs=f"{4 * MIN_LEVEL} events with volumes that are not exact",
    build=lambda facts: VolumeErrorEffect("volume-error", _log_factor(facts["highest"])),
    lacking=_few_volumes,
    # Errors cannot scatter the recorded volumes more than these do.
    facts=lambda columns, _sites: {
        "highest": float(np.clip(np.log(max(largest_factor(columns), 1e-9)), 0.0, MOST))
    },
    order=166,
)
