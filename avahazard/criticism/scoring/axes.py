"""The axes along which a model may fail: for each, the events' levels, in words.

What lies at the stop is taken at the predicted stop, not at the record's: events that by chance
stopped high would otherwise be found to have stopped higher than predicted.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.inference.model.observations import Observations

Levels = NDArray[np.str_]

MONTHS = ("January", "February", "March", "April", "May", "June", "July", "August", "September",
          "October", "November", "December")  # fmt: skip
MAX_LEVELS_OF_NUMBERS = 3


def event_axes(observations: Observations, predicted_x: Floats) -> dict[str, Levels]:
    """Level of every event `[n_events]` by axis; '' where it is not known.

    `predicted_x` `[n_events]` (m) is the place of the predicted stop. Numbers are cut at their
    terciles.
    """
    columns = observations.columns
    names = np.array([*columns.paths, ""])
    axes: dict[str, Levels] = {
        "path": names[columns.path_index],
        "volume": terciles(np.exp(columns.log_volume), _volume),
        "year": terciles(columns.year, lambda v: f"{v:.0f}"),
        "month": _months(observations),
        "release_elevation_m": terciles(columns.release_elevation, _metres),
        "section": columns.section,
        "orientation": _path_words(
            observations, [s.path.orientation or "" for s in observations.sites]
        ),
        **_at_the_stop(observations, predicted_x),
    }
    for name, values in columns.numbers.items():
        axes.setdefault(name, _number_levels(values))
    for name, texts in columns.texts.items():
        axes.setdefault(name, texts)
    return {name: np.asarray(levels, dtype=np.str_) for name, levels in axes.items()}


def _at_the_stop(observations: Observations, x: Floats) -> dict[str, Levels]:
    """Elevation, slope, share of the path and land cover at the predicted stops."""
    n = observations.n_events
    height, slope, share = (np.full(n, np.nan) for _ in range(3))
    cover = np.full(n, "", dtype=object)
    for k, site in enumerate(observations.sites):
        mine = np.flatnonzero(observations.columns.path_index == k)
        smooth = site.smooth
        at = np.clip(x[mine], smooth.x_min, smooth.x_max)
        height[mine] = smooth.height(at)
        slope[mine] = np.degrees(np.arctan(-np.asarray(smooth.derivatives(at)[1])))
        share[mine] = (at - smooth.x_min) / (smooth.x_max - smooth.x_min)
        if site.land_cover is not None:
            point = np.searchsorted(site.profile_x, at, side="right") - 1
            cover[mine] = np.asarray(site.land_cover)[np.clip(point, 0, len(site.profile_x) - 1)]
    return {
        "predicted_stop_elevation_m": terciles(height, _metres),
        "slope_at_predicted_stop": terciles(slope, lambda v: f"{v:.0f}°"),
        "place_along_path": terciles(share, lambda v: f"{v:.0%}"),
        "land_cover_at_predicted_stop": cover.astype(np.str_),
    }


def terciles(values: Floats, write: Callable[[float], str]) -> Levels:
    """Lower, middle and upper third, named by their edges; '' where nan."""
    known = np.isfinite(values)
    levels = np.full(len(values), "", dtype=object)
    if np.any(known) and np.ptp(values[known]) > 0.0:
        low, high = np.quantile(values[known], [1 / 3, 2 / 3])
        levels[known & (values <= low)] = f"up to {write(low)}"
        levels[known & (values > low) & (values <= high)] = f"{write(low)} to {write(high)}"
        levels[known & (values > high)] = f"above {write(high)}"
    return levels.astype(np.str_)


def _number_levels(values: Floats) -> Levels:
    """A column of numbers: few different ones are levels, others are cut at their terciles."""
    if len(np.unique(values[np.isfinite(values)])) <= MAX_LEVELS_OF_NUMBERS:
        return np.array([f"{v:g}" if np.isfinite(v) else "" for v in values], dtype=np.str_)
    return terciles(values, lambda v: f"{v:.4g}")


def _months(observations: Observations) -> Levels:
    day = observations.columns.day_of_winter
    # Days counted from 1 November of a year that is not a leap year.
    start = np.datetime64("2000-11-01", "D")
    months = [
        ""
        if np.isnan(d)
        else MONTHS[int((start + int(d)).astype("datetime64[M]").astype(int) % 12)]
        for d in day
    ]
    return np.array(months, dtype=np.str_)


def _path_words(observations: Observations, words: list[str]) -> Levels:
    return np.array([*words, ""])[observations.columns.path_index]


def _volume(value: float) -> str:
    """Two leading digits and a thin gap for thousands: 80 000 m3."""
    digits = max(0, int(np.floor(np.log10(max(value, 1.0)))) - 1)
    return f"{round(value, -digits):,.0f} m3".replace(",", " ")


def _metres(value: float) -> str:
    return f"{value:.0f} m"
