"""What a model says of stops, and how far a volume lies beyond its records."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from avahazard.arrays import Floats
from avahazard.inference.fitted_model import FittedModel, table_groups
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.model.observations import ELEVATION, LENGTH, Observations
from avahazard.inference.model.volumes import drawn_log_volumes
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU, between, located, nearest, steps_of
from avahazard.records.collection import Event

LEAST_HELD = 1e-3
"""No flow is known to slide on less; draws of μ ≤ 0 count as the lowest friction of the tables."""
NUMBERS_AT_ONCE = 500_000
"""Numbers of the tables and of the draws that are looked up together: it takes some 20 of each."""
DRAWS_AT_ONCE = 100
"""Draws of all events that are looked up before they find their place among the others."""
MAX_TABLES = 12
"""Draws of the parameters that shape the tables, each of which costs runs of every block."""


@dataclass(frozen=True, slots=True, eq=False)
class PredictedStops:
    """Draws of where events stop, `[n_events, n_draws]`, without the error of the record.

    `record` is in the coordinate of each event's record, `x` and `elevation` in metres; where
    `left`, they are those of the profile's end. `friction` is the draw of μ: those ≤ 0 run beyond
    any profile (normal scatter only). `sigma` (m) is the error that each record would have.
    """

    record: Floats
    x: Floats
    elevation: Floats
    left: NDArray[np.bool_]
    friction: Floats
    sigma: Floats


def predict_stops(
    model: FittedModel, n_draws: int, rng: np.random.Generator, *, release_off: bool = False
) -> PredictedStops:
    """Draw stops of every event of the model, whose draws are thinned to `n_draws`.

    A new group gets an offset from the spread between groups. With `release_off` releases are off
    by their stated error where it is whether a block leaves (what it does to stops is part of
    `sigma`).
    """
    posterior, coordinates = model.posterior, model.draws
    n = posterior.observations.n_events
    chosen = model.thinned(n_draws)
    tables_at = coordinates[chosen][:, list(posterior.layout.tables)]
    groups = table_groups(tables_at, min(MAX_TABLES, n_draws))
    friction, record, x, elevation = (np.empty((n, n_draws)) for _ in range(4))
    sigma = np.empty((n, len(groups)))
    of_group = np.empty(n_draws, dtype=np.int64)
    left = np.empty((n, n_draws), dtype=np.bool_)
    for g, group in enumerate(groups):
        # All draws of a group share the table parameters of the draw nearest to their mean.
        away = np.sum((tables_at[group] - tables_at[group].mean(axis=0)) ** 2, axis=1)
        middle = coordinates[chosen[group[np.argmin(away)]]]
        tables = posterior.nodes.predicted_at(middle)
        for k in group:
            u = coordinates[chosen[k]].copy()
            u[list(posterior.layout.tables)] = middle[list(posterior.layout.tables)]
            shift = group_shift(model, u, chosen[k], rng)
            friction[:, k] = draw_friction(posterior, u, shift, rng)
        sigma[:, g], of_group[group] = tables.sigma, g
        for some in np.array_split(group, -(-len(group) // DRAWS_AT_ONCE)):
            found = look_up(tables, friction[:, some])
            record[:, some], x[:, some], elevation[:, some], left[:, some] = found
        unsure = tables.leaving_sigma > 0.0
        if release_off and unsure.any():
            off = tables.leaving_sigma[:, None] * rng.standard_normal((n, len(group)))
            by_chance = look_up(tables, friction[:, group] * np.exp(off))[3]
            left[:, group] = np.where(unsure[:, None], by_chance, left[:, group])
    # One column stands for all where no parameter shapes the tables.
    whole = np.broadcast_to(sigma, friction.shape) if len(groups) == 1 else sigma[:, of_group]
    return PredictedStops(record, x, elevation, left, friction, whole)


def draw_friction(
    posterior: Posterior, u: Floats, shift: Floats, rng: np.random.Generator
) -> Floats:
    """One draw of μ for each event `[n_events]`; `shift` `[n_events]` is added to log friction."""
    volumes, friction = posterior.volumes(u), posterior.friction
    volume = np.exp(drawn_log_volumes(volumes, rng.standard_normal(len(volumes.mean))))
    location, scatter = friction.location_and_scatter(u, volume[:, None], posterior.of_events)
    return friction.draw(u, friction.shifted(location[:, 0], shift), scatter[:, 0], rng)


def group_shift(model: FittedModel, u: Floats, draw: int, rng: np.random.Generator) -> Floats:
    """Offsets of log friction of each event's groups in this draw, `[n_events]`."""
    plan, offsets = model.posterior.plan, model.offsets
    if not plan:
        return np.zeros(model.observations.n_events)
    new = model.posterior.layout.spread_values(u)[plan.of] * rng.standard_normal(len(plan.of))
    known = [offsets[n][draw] if n in offsets else new[k] for k, n in enumerate(plan.names)]
    return plan.shift(np.array(known, np.float64))


def look_up(
    tables: Predicted, friction: Floats
) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Records, places, elevations, and what left, at drawn frictions `[n_events, n_draws]`."""
    straight = np.isnan(tables.elevation).all(axis=1)
    # Without a profile the energy line holds exactly, for any friction: L = H / μ.
    height = tables.record[straight, :1] * MU[0]
    held = friction[straight]
    lengths = height / np.where(held > 0.0, np.maximum(held, LEAST_HELD), MU[0])
    if straight.all():
        nowhere = np.broadcast_to(np.nan, friction.shape)
        return lengths, nowhere, nowhere, np.zeros(friction.shape, np.bool_)
    record, x, elevation = (np.empty(friction.shape) for _ in range(3))
    left = np.empty(friction.shape, dtype=np.bool_)
    n_rows = max(1, NUMBERS_AT_ONCE // max(len(MU), friction.shape[1]))
    for first in range(0, len(friction), n_rows):
        some = slice(first, first + n_rows)
        curve = tables.curve[some]
        cell, share = located(steps_of(friction[some]), curve.discontinuous)
        record[some] = between(tables.record[some], cell, share)
        x[some], elevation[some] = between(curve.x, cell, share), between(curve.y, cell, share)
        left[some] = (nearest(curve.status, cell, share) == LEFT_PROFILE) | (friction[some] <= 0.0)
    record[straight] = lengths
    left[straight] = False
    return record, x, elevation, left


Stops = tuple[Floats, NDArray[np.bool_]]
"""Where events stop (m, or H/L), and whether beyond the profile, `[n_events, n_draws]` each."""

N_RELEASES = 25
AT_ONCE = 20
"""Events that are run from all their releases at once: memory."""
LEAST_FALL = 1e-3
"""Share of the fall that is left at least, on a straight line."""


def stops_over_releases(
    on: Callable[[Sequence[Event]], FittedModel],
    events: Sequence[Event],
    sigma: Floats,
    n_draws: int,
    rng: np.random.Generator,
) -> Stops:
    """Draws of where events stop whose releases are off by `sigma` `[n_events]` (m of elevation).

    `on` gives the model on events of its paths. Each draw starts from one of `N_RELEASES` places,
    as likely each.
    """
    values, left = np.empty((len(events), n_draws)), np.empty((len(events), n_draws), np.bool_)
    known = on(events).observations
    for first in range(0, len(events), AT_ONCE):
        selected = range(first, min(first + AT_ONCE, len(events)))
        copies = [
            copy for i in selected for copy in from_each_release(events[i], sigma[i], known, i)
        ]
        model = on(copies)
        stops = predict_stops(model, n_draws, rng)
        there = told(model.observations, stops.record, stops.elevation)
        for k, i in enumerate(selected):
            # Draws run through the posterior in order; their releases must not.
            start = k * N_RELEASES + rng.permutation(np.arange(n_draws) % N_RELEASES)
            values[i] = there[start, np.arange(n_draws)]
            left[i] = stops.left[start, np.arange(n_draws)]
    return values, left


def told(observations: Observations, record: Floats, elevation: Floats) -> Floats:
    """Elevations, or without a profile lengths or H/L, `[n_events, n_draws]`."""
    lengths = observations.kind == LENGTH
    return np.where(lengths[:, None], observations.as_recorded(record), elevation)


def from_each_release(
    event: Event, sigma: float, observations: Observations, i: int
) -> list[Event]:
    """The event, number `i` of the observations, from each release within its error `sigma` (m).

    On a straight line the fall changes, else the elevation of the start; over the top of the
    profile is its top.
    """
    places = sigma * normal_places(N_RELEASES)
    if event.path_id is None:
        fall = float(observations.fall_height[i])
        return [
            replace(event, fall_height_m=max(fall + float(z), LEAST_FALL * fall)) for z in places
        ]
    height = float(observations.columns.release_elevation[i])
    return [replace(event, release_elevation_m=height + float(z)) for z in places]


def normal_places(n: int) -> Floats:
    """Middles `[n]` of equal shares of the standard normal, stretched to its variance."""
    places = ndtri((np.arange(n) + 0.5) / n)
    return np.asarray(places / np.sqrt(np.mean(places**2)))


MOST_OFF = 0.9
"""Share of the friction: errors as large as the fall itself say no more than that."""


def ground_error(model: FittedModel, friction: Floats | None = None) -> Floats:
    """Standard deviation `[n_events]` (m, in each record's coordinate) of the predicted stop.

    By the errors of the profile's heights (docs/theory/criticism.md, "The error budget"). Every
    event keeps its `friction` `[n_events]`, by default the posterior median for its volume. A
    runout beyond the profile counts as at its end. Zero without a profile, or where the ground is a
    polynomial of points without error.
    """
    observations, posterior = model.observations, model.posterior
    if friction is None:
        friction = model.median_friction(np.exp(observations.volumes.mean))
    tables = posterior.nodes.predicted_at(model.draws.mean(axis=0))
    stop = look_up(tables, friction[:, None])[1][:, 0]
    released, start, end = _errors(observations, stop)
    reach = np.maximum(stop - released, 1.0)
    off = np.where(start + end > 0.0, np.hypot(start, end) / reach, 0.0)
    off = np.minimum(off, MOST_OFF * friction)
    around = look_up(tables, friction[:, None] + off[:, None] * np.array([-1.0, 1.0]))[0]
    moved = 0.5 * np.abs(around[:, 1] - around[:, 0])
    # By a metre of height at either end, and the stop's own height on top.
    steep = np.divide(moved, np.hypot(start, end), out=np.zeros_like(moved), where=off > 0.0)
    own = end * (observations.kind == ELEVATION)
    return np.asarray(np.hypot(steep * start, steep * end + own))


def _errors(observations: Observations, stop: Floats) -> tuple[Floats, Floats, Floats]:
    """x of each release (m) `[n_events]`, and the ground's error (m) there and at each `stop`."""
    n = observations.n_events
    released, start, end = np.zeros(n), np.zeros(n), np.zeros(n)
    for k, site in enumerate(observations.sites):
        selected = np.flatnonzero(observations.columns.path_index == k)
        released[selected] = site.release_x[observations.release[selected]]
        if site.smooth.posterior is None or not len(selected):
            continue
        places = np.concatenate([released[selected], stop[selected]])
        start[selected], end[selected] = np.split(site.smooth.posterior.sd(places), 2)
    return released, start, end


LEAST_FRICTION, MOST_FRICTION = 0.1, 1.5
"""What Coulomb friction of avalanches may be.

Extreme snow avalanches are given no less than 0.155 (Salm, Burkard & Gubler 1990), and H/L of the
largest rock avalanches comes down to 0.1 (Scheidegger 1973). Slabs hardly hold on slopes of over
55 degrees (McClung & Schaerer 2006): snow that slides there has less than their tangent, 1.4.
"""
RARE = 0.01
"""A share of draws outside that is not worth a word."""
BEYOND = 1.001
"""A volume this many times the largest recorded is beyond it."""


def extrapolation(
    model: FittedModel, path_id: str | None, volume_m3: float, *of: str
) -> list[Note]:
    """Notes on a volume on a path (None: of none) against the events that `model` was fitted on.

    On how far it is beyond the largest recorded volumes, of the path and of all, and on the share
    of its frictions outside what physics allows. `of` is the path, if it is to be said.
    """
    columns = model.columns
    recorded = np.exp(columns.log_volume)
    selected = np.zeros(len(recorded), dtype=np.bool_)
    if path_id in columns.paths:
        selected = columns.path_index == columns.paths.index(path_id)
    largest_of_path, largest = _largest(recorded[selected]), _largest(recorded)
    past_path, past_all = (volume_m3 > BEYOND * v for v in (largest_of_path, largest))
    values = {
        "volume": _rounded(volume_m3, 3),
        "times_path": _times(volume_m3 / largest_of_path) if past_path else 0.0,
        "largest_of_path": _rounded(largest_of_path, 3),
        "times": _times(volume_m3 / largest) if past_all else 0.0,
        "largest": _rounded(largest, 3),
    }
    notes = []
    if past_path:
        notes.append(Note("beyond_both" if past_all else "beyond_path", of, **values))
    elif past_all:
        notes.append(Note("beyond_all", of, **values))
    drawn = drawn_frictions(model, path_id, volume_m3)
    for key, share, limit in (
        ("friction_too_low", float(np.mean(drawn < LEAST_FRICTION)), LEAST_FRICTION),
        ("friction_too_high", float(np.mean(drawn > MOST_FRICTION)), MOST_FRICTION),
    ):
        if share > RARE:
            figures = {"share": share, "limit": limit, "median": float(np.median(drawn))}
            notes.append(Note(key, of, volume=values["volume"], **figures))
    return notes


def drawn_frictions(model: FittedModel, path_id: str | None, volume_m3: float) -> Floats:
    """Draws of friction `[n_draws]` of a volume on a path (None: of none), with scatter and offset.

    Of its middle alone where the stop scatters, not friction. Effects that look at columns of the
    event are at their reference.
    """
    friction, u = model.friction, model.draws
    location, scatter = friction.location_and_scatter(u, np.array([[volume_m3]]))
    rng = generator(0, "extrapolation")
    tau = model.layout.spread_values(u)
    shift = np.zeros(len(u))
    for g, persistent in enumerate(friction.persistent):
        known = model.offsets.get(path_id or "") if persistent else None
        shift = shift + (tau[:, g] * rng.standard_normal(len(u)) if known is None else known)
    middle = friction.shifted(location[:, 0, 0], shift)
    if model.sigma_m is not None:
        return np.exp(middle) if model.layout.log_scatter else middle
    return friction.draw(u, middle, scatter[:, 0, 0], rng)


def _largest(volume: Floats) -> float:
    """The largest of those that are known; inf without any, which nothing is beyond."""
    known = volume[np.isfinite(volume)]
    return float(known.max()) if len(known) else np.inf


def _times(times: float) -> float:
    """Two digits, as 1.4 or 140; three below 1.1, and no less than 1.01: it is never once."""
    return _rounded(max(times, 1.01), 3 if times < 1.1 else 2)


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}") if np.isfinite(value) else 0.0
