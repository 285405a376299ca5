"""Where a model fails: its bias along every axis, and whether chance could do that.

What lies at the stop is taken at the predicted stop, not at the record's: events that by chance
stopped high would otherwise be found to have stopped higher than predicted.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri, stdtr

from avahazard.arrays import Floats
from avahazard.effects.columns import FALL_HEIGHT
from avahazard.inference.model.observations import Observations
from avahazard.notes import Note
from avahazard.results.base import Rows
from avahazard.results.comparison import Failure

MIN_EVENTS = 5
MIN_PATHS = 5
PIT_EDGE = 1e-6
Levels = NDArray[Any]
"""Names or notes `[n_events]`."""

MONTHS = ("January", "February", "March", "April", "May", "June", "July", "August", "September",
          "October", "November", "December")  # fmt: skip
MAX_LEVELS_OF_NUMBERS = 3


def where_it_fails(
    axes: Mapping[str, Levels], error: Floats, pit: Floats, path: NDArray[np.int64]
) -> Rows[Failure]:
    """The bias of each level of each axis, the least likely first.

    `error` `[n_events]` is predicted mean minus record (m), `pit` the rank of the record in its
    predictive distribution, `path` the index of each event's path. The p-value is that of the
    mean of Φ⁻¹(PIT) in a level (two-sided). Events of one path are not independent: with five
    paths or more, axes other than the path allow for a spread between paths, and a level is held
    against the other events (`contrast_p_values`). Values are corrected for the number of axes,
    which count alike and share their part among their levels (`holm`): a column of thirty words
    hides no other. Levels of fewer than five events are left out.
    """
    z = ndtri(np.clip(pit, PIT_EDGE, 1.0 - PIT_EDGE))
    clustered = len(np.unique(path[path >= 0])) >= MIN_PATHS
    rows: list[Failure] = []
    for axis, levels in axes.items():
        known = levels != ""
        names, counts = np.unique(levels[known], return_counts=True)
        if len(names) < 2:
            continue
        if clustered and axis != "path":
            p_of = contrast_p_values(z[known], levels[known], path[known])
        else:
            z_sum = np.array([np.sum(z[levels == name]) for name in names])
            p_values = 2.0 * ndtr(-abs(z_sum) / np.sqrt(counts))
            p_of = dict(zip(map(str, names), p_values.tolist(), strict=True))
        for name, n in zip(names, counts, strict=True):
            if n >= MIN_EVENTS and str(name) in p_of:
                bias = float(np.mean(error[levels == name]))
                rows.append(Failure(axis, Note.read(name), int(n), bias, p_of[str(name)]))
    levels_of = Counter(row.axis for row in rows)
    corrected = holm([row.p_value for row in rows], [1.0 / levels_of[row.axis] for row in rows])
    rows = [replace(row, p_value=p) for row, p in zip(rows, corrected, strict=True)]
    return Rows(sorted(rows, key=lambda row: (row.p_value, -abs(row.bias_m))))


def holm(p_values: list[float], weights: list[float] | None = None) -> list[float]:
    """p-values corrected for their number, each by its weight (Holm 1979)."""
    weights = [1.0] * len(p_values) if weights is None else weights
    adjusted = [1.0] * len(p_values)
    highest, left = 0.0, sum(weights)
    for k in np.argsort(np.divide(p_values, weights), kind="stable"):
        highest = max(highest, min(1.0, left * p_values[k] / weights[k]))
        adjusted[k] = highest
        left -= weights[k]
    return adjusted


def contrast_p_values(z: Floats, levels: Levels, path: NDArray[np.int64]) -> dict[str, float]:
    """p-value of every level against the other events, where paths may differ too.

    z = a + d x + b(path) + e, with x = 1 in the level: d is found from the events within paths and
    from the means of paths, each weighted by what it knows. A level that is the same on a whole
    path is informed by the means alone, one that varies within paths hardly needs them.

    Empty where each lies on one path only: then nothing can be said beyond the paths. Arguments are
    `[n_events]`, z of unit variance.
    """
    names = np.unique(levels)
    cells = np.unique(np.column_stack([np.searchsorted(names, levels), path]), axis=0)
    if len(cells) == len(names):
        return {}
    _, path = np.unique(path, return_inverse=True)
    tested = {str(name): contrast_p(z, (levels == name).astype(float), path) for name in names}
    return {name: p for name, p in tested.items() if p is not None}


def contrast_p(z: Floats, x: Floats, path: NDArray[np.int64]) -> float | None:
    """Two-sided p-value of d = 0 by t; None where the data do not hold it.

    Variances within and between paths are by moments; the degrees of freedom are those of the
    two estimates of d combined.
    """
    count = np.bincount(path)
    x_mean, z_mean = np.bincount(path, x) / count, np.bincount(path, z) / count
    x_in, z_in = x - x_mean[path], z - z_mean[path]
    squares = float(np.sum(x_in**2))
    varies = squares > 1e-9 * len(x)
    slope = float(np.sum(x_in * z_in)) / squares if varies else 0.0
    free_within = len(z) - len(count) - int(varies)
    within = 1.0
    if free_within > 0:
        # Ranks of a right model have variance one; less is chance.
        within = max(1.0, float(np.sum((z_in - slope * x_in) ** 2)) / free_within)
    free_between, between = _between(x_mean, z_mean, count, within)
    weight = 1.0 / (within / count + between)
    ahead = x_mean - np.sum(weight * x_mean) / np.sum(weight)
    known_within = squares / within if varies and free_within > 0 else 0.0
    known_between = float(np.sum(weight * ahead**2)) if free_between > 0 else 0.0
    known = known_within + known_between
    if known <= 1e-9:
        return None
    part = slope * known_within
    if known_between > 0.0:
        part += float(np.sum(weight * ahead * z_mean))
    parts = (known_within, free_within), (known_between, free_between)
    uncertain = sum((each / known) ** 2 / free for each, free in parts if each > 0.0)
    return float(2.0 * stdtr(1.0 / uncertain, -abs(part) / np.sqrt(known)))


def _between(
    x_mean: Floats, z_mean: Floats, count: NDArray[np.int64], within: float
) -> tuple[int, float]:
    """Degrees of freedom and variance of the offsets of paths, about a line in their mean x."""
    columns = [np.ones(len(count))]
    if np.ptp(x_mean) > 1e-9:
        columns.append(x_mean)
    design = np.column_stack(columns)
    free = len(count) - design.shape[1]
    if free < 1:
        return 0, 0.0
    inverse = np.linalg.inv(design.T @ (count[:, None] * design))
    line = design @ (inverse @ (design.T @ (count * z_mean)))
    squares = float(np.sum(count * (z_mean - line) ** 2))
    expected = np.sum(count) - np.trace(inverse @ (design.T @ (count[:, None] ** 2.0 * design)))
    return free, max(0.0, (squares - free * within) / float(expected))


def event_axes(observations: Observations, predicted_x: Floats) -> dict[str, Levels]:
    """Level of every event `[n_events]` by axis; '' where it is not known.

    `predicted_x` `[n_events]` (m) are the predicted stops. Numbers are cut at their terciles.
    """
    columns = observations.columns
    names = np.array([*columns.paths, ""])
    orientations = [*(s.path.orientation or "" for s in observations.sites), ""]
    axes: dict[str, Levels] = {
        "path": names[columns.path_index],
        "volume": terciles(np.exp(columns.log_volume), ",.0f", " m3", leading=2),
        "year": terciles(columns.year, ".0f"),
        "month": _months(observations),
        "release_elevation_m": terciles(columns.release_elevation, ".0f", " m"),
        "section": columns.section,
        "orientation": np.array(orientations, dtype=np.object_)[columns.path_index],
        **_at_the_stop(observations, predicted_x),
    }
    for name, values in columns.numbers.items():
        if name != FALL_HEIGHT:
            axes.setdefault(name, _number_levels(values))
    for name, texts in columns.texts.items():
        axes.setdefault(name, texts)
    return {name: np.asarray(levels, dtype=np.object_) for name, levels in axes.items()}


def _at_the_stop(observations: Observations, x: Floats) -> dict[str, Levels]:
    """Elevation, slope, share of the path and land cover at the predicted stops."""
    n = observations.n_events
    height, slope, share = (np.full(n, np.nan) for _ in range(3))
    cover = np.full(n, "", dtype=object)
    for k, site in enumerate(observations.sites):
        selected = np.flatnonzero(observations.columns.path_index == k)
        smooth = site.smooth
        at = np.clip(x[selected], smooth.x_min, smooth.x_max)
        height[selected] = smooth.height(at)
        slope[selected] = np.degrees(np.arctan(-np.asarray(smooth.derivatives(at)[1])))
        share[selected] = (at - smooth.x_min) / (smooth.x_max - smooth.x_min)
        if site.profile.land_cover is not None:
            cover[selected] = site.cover(at)
    return {
        "predicted_stop_elevation_m": terciles(height, ".0f", " m"),
        "slope_at_predicted_stop": terciles(slope, ".0f", "°"),
        "place_along_path": terciles(share, ".0%"),
        "land_cover_at_predicted_stop": cover,
    }


def terciles(values: Floats, form: str, unit: str = "", leading: int | None = None) -> Levels:
    """Lower, middle and upper third, notes on their edges in a form and unit; '' where nan."""
    known = np.isfinite(values)
    levels = np.full(len(values), "", dtype=object)
    if np.any(known) and np.ptp(values[known]) > 0.0:
        low, high = np.quantile(values[known], [1 / 3, 2 / 3])
        a, b = (float(v if leading is None else f"{v:.{leading}g}") for v in (low, high))
        how = {"form": form, "unit": unit}
        levels[known & (values <= low)] = Note("up_to", edge=a, **how)
        levels[known & (values > low) & (values <= high)] = Note("from_to", low=a, high=b, **how)
        levels[known & (values > high)] = Note("above", edge=b, **how)
    return levels


def _number_levels(values: Floats) -> Levels:
    """A column of numbers: few different ones are levels, others are cut at their terciles."""
    if len(np.unique(values[np.isfinite(values)])) <= MAX_LEVELS_OF_NUMBERS:
        levels = [Note("number", value=float(v)) if np.isfinite(v) else "" for v in values]
        return np.array(levels, dtype=np.object_)
    return terciles(values, ".4g")


def _months(observations: Observations) -> Levels:
    day = observations.columns.day_of_winter
    # Days counted from 1 November of a year that is not a leap year.
    start = np.datetime64("2000-11-01", "D")
    known, levels = np.isfinite(day), np.full(len(day), "", dtype=np.object_)
    month = (start + day[known].astype(int)).astype("datetime64[M]").astype(int) % 12
    levels[known] = np.array(MONTHS, dtype=np.object_)[month]
    return levels
