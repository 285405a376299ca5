"""Quadrature nodes over friction: what a record says about the friction of its event.

p(record | μ), narrow over friction, is summed up by the nodes of the Gauss quadrature that has it
as weight (Golub and Welsch 1969): p(record | m, σ) ≈ Σ_k w_k p(ν_k | m, σ), ν = log μ. Events that
ran beyond the profile give w₀ + Σ_k w_k P(ν < ν_k), and so does the chance that a stop was seen.
With Student's tails a record is a mixture (Box and Tiao 1968, Biometrika 55, 119): a share of all
lies anywhere on their path (`layout.WRONG_SHARE`). See docs/theory/likelihood.md.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats, Ints
from avahazard.inference.likelihood.predicted import Predicted
from avahazard.inference.likelihood.quadrature import N_NODES, finest, n_panels, nodes_used
from avahazard.inference.likelihood.record_nodes import (
    edges_of_leaving,
    edges_of_sight,
    hidden_from,
    record_density_nodes,
    straight_density_nodes,
)
from avahazard.inference.likelihood.track_nodes import TrackRows, fill_track_nodes, track_rows
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, Observations
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.cells import GRAVITY
from avahazard.physics.runout_curve import MU
from avahazard.workers import n_workers, ordered_map


class Nodes(NamedTuple):
    """Nodes of all events, `[n_events, n_nodes]`; `place` is ν, or μ for normal scatter.

    `used` `[n_events]` counts those of each event; others have weight 0. `tail` `[n_events, 2]`
    are weights of P(ν < place) and P(ν > place) at `tail_place` `[n_events, 2]`.
    `is_probability` `[n_events]`: the event ran beyond its profile, and its nodes are edges of
    probabilities. `log_scale` `[n_events]` is the log of what all weights are multiplied by,
    `floor` `[n_events]` is w₀, `log_wrong` `[n_events]` that of a wrong record (or -inf).
    `seen_place`, `seen_weight`, `seen_floor` give the chance to be seen, where `has_limit`.
    """

    place: Floats
    weight: Floats
    used: Ints
    tail_place: Floats
    tail: Floats
    log_scale: Floats
    is_probability: NDArray[np.bool_]
    floor: Floats
    seen_place: Floats
    seen_weight: Floats
    seen_floor: Floats
    has_limit: NDArray[np.bool_]
    log_wrong: Floats


def build_nodes(
    observations: Observations,
    predicted: Predicted,
    track_scatter: float = 0.0,
    limit: Floats | None = None,
    in_log: bool = True,
    panels: Ints | None = None,
) -> Nodes:
    """Nodes of every event for one set of tables.

    `track_scatter` is the standard deviation of friction along the tracks; `limit` `[n_events]` are
    elevations above which no stop is recorded, where none is declared; nodes are in log μ, or in μ
    without `in_log`; `panels` `[n_events]` are those of `needed_panels`.
    """
    if panels is None:
        panels = needed_panels(observations, predicted, track_scatter, in_log)
    records = record_nodes(observations, predicted, panels, limit, in_log)
    if not observations.speeds:
        return records
    tracks = track_rows(observations, predicted)
    return with_tracks(records, tracks, track_scatter, panels, in_log)


def needed_panels(
    observations: Observations, predicted: Predicted, track_scatter: float, in_log: bool
) -> Ints:
    """Panels of friction for each event `[n_events]`: 1 but for likelihoods that are wide."""
    one = np.ones(observations.n_events, dtype=np.int64)
    nodes = build_nodes(observations, predicted, track_scatter, None, in_log, one)
    # Chances of leaving may rise and fall; it is how far apart their edges lie that counts.
    weight = np.where(nodes.is_probability[:, None], np.abs(nodes.weight), nodes.weight)
    sharp = nodes.is_probability & (predicted.leaving_sigma == 0.0)
    return np.where(sharp, 1, n_panels(nodes.place, weight, in_log))


def record_nodes(
    observations: Observations,
    predicted: Predicted,
    panels: Ints,
    limit: Floats | None = None,
    in_log: bool = True,
) -> Nodes:
    """Nodes of the events without speeds; those of the others are left blank."""
    n, grid, most_apart = observations.n_events, np.log(MU) if in_log else MU, finest(in_log)
    has_speed = np.zeros(n, dtype=np.bool_)
    has_speed[[m.event for m in observations.speeds]] = True
    seen_limit = observations.limit if limit is None else limit
    declared = np.isfinite(observations.limit)
    # A limit that is estimated; elevations are looked at on profiles alone.
    nowhere = np.isnan(predicted.elevation).all(axis=1)
    estimated = np.where(nowhere | declared, np.nan, seen_limit)
    hidden = hidden_from(observations, predicted, in_log)
    left, sigma, observed = predicted.status == LEFT_PROFILE, predicted.sigma, observations.observed
    has_left = observations.kind == LEFT
    straight = (observations.kind == LENGTH) & np.isfinite(observations.fall_height * observed)
    used = nodes_used(panels)
    place, weight, seen_place, seen_weight = np.zeros((4, n, np.max(used, initial=N_NODES)))
    tail_place, tail = np.tile(grid[[0, -1]], (n, 1)), np.zeros((n, 2))
    log_scale, floor, seen_floor = np.zeros(n), np.zeros(n), np.ones(n)
    no_speed = np.zeros(len(grid))
    for i in range(n):
        selected = place[i], weight[i]
        if has_left[i] and not has_speed[i]:
            selected = place[i, : used[i]], weight[i, : used[i]]
            off = predicted.leaving_sigma[i]
            floor[i] = edges_of_leaving(left[i], off, grid, in_log, most_apart, *selected)
        elif straight[i]:
            lengths = observations.fall_height[i], observed[i], sigma[i]
            log_scale[i], tail_place[i, 1] = straight_density_nodes(
                *lengths, in_log, panels[i], *selected, tail[i]
            )
        elif not has_speed[i]:
            stops = predicted.record[i], left[i], has_left[i], observed[i], sigma[i]
            within = no_speed, grid, hidden[i], panels[i], most_apart
            log_scale[i] = record_density_nodes(*stops, *within, *selected, tail[i])
        if hidden[i] < np.inf:
            seen_floor[i], seen_place[i, 0], seen_weight[i, 0] = 0.0, hidden[i], 1.0
        elif not np.isnan(estimated[i]):
            elevation = np.nan_to_num(predicted.elevation[i], nan=0.0)
            seen = seen_place[i], seen_weight[i]
            seen_floor[i] = edges_of_sight(
                elevation, left[i], estimated[i], sigma[i], grid, panels[i], most_apart, *seen
            )
    return Nodes(
        place=place,
        weight=weight,
        used=used,
        tail_place=tail_place,
        tail=tail,
        log_scale=log_scale,
        is_probability=has_left & ~has_speed,
        floor=floor,
        seen_place=seen_place,
        seen_weight=seen_weight,
        seen_floor=seen_floor,
        has_limit=(hidden < np.inf) | ~np.isnan(estimated),
        log_wrong=np.full(n, -np.inf),
    )


def with_tracks(
    records: Nodes, tracks: Sequence[TrackRows], scatter: float, panels: Ints, in_log: bool
) -> Nodes:
    """`record_nodes` with those of the events with speeds filled in.

    `scatter` is that of friction along the tracks, `panels` `[n_events]` as in `needed_panels`.
    """
    filled = ("place", "weight", "tail", "log_scale")
    nodes = records._replace(**{name: getattr(records, name).copy() for name in filled})

    def fill(part: Ints) -> None:
        for track in [tracks[k] for k in part]:
            i, used = track.event, slice(nodes.used[track.event])
            some = nodes.place[i, used], nodes.weight[i, used], nodes.tail[i]
            nodes.log_scale[i] = fill_track_nodes(track, scatter, panels[i], in_log, *some)

    list(ordered_map(fill, np.array_split(np.arange(len(tracks)), min(n_workers(), len(tracks)))))
    return nodes


LEAST_FALL = 1.0
"""Metres that a track with speeds has fallen at least."""
LONGEST_LENGTH = 10.0
"""Reach of recorded lengths, in fall heights."""


def wrong_ranges(observations: Observations) -> tuple[Floats, Floats]:
    """Lowest and highest record (m) that each event could have had `[n_events]`.

    NaN for those beyond the profile.
    """
    low, high = np.full(observations.n_events, np.nan), np.full(observations.n_events, np.nan)
    for i, kind in enumerate(observations.kind):
        if kind == LENGTH:
            low[i], high[i] = 0.0, LONGEST_LENGTH * observations.fall_height[i]
        elif kind != LEFT:
            site = observations.sites[observations.columns.path_index[i]]
            line = site.heights() if kind == ELEVATION else site.terrain_x
            low[i], high[i] = np.min(line), np.max(line)
    return low, high


def log_wrong(observations: Observations) -> Floats:
    """Log density of each event's record, were it wrong `[n_events]`; -inf for those that are not.

    In 1/m, and 1/(m/s) for each speed: those of a wrong track lie anywhere up to free fall.
    """
    low, high = wrong_ranges(observations)
    density = -np.log(high - low)
    for track in observations.speeds:
        smooth = observations.sites[observations.columns.path_index[track.event]].smooth
        fall = smooth.height(np.array([track.release_x])) - smooth.height(track.x)
        density[track.event] -= 0.5 * np.sum(np.log(2.0 * GRAVITY * np.maximum(fall, LEAST_FALL)))
    return np.where(np.isnan(density), -np.inf, density)


def by_wrong_share(log_wrong: Floats, value: Floats, log_share: float) -> Floats:
    """Derivative by the log of the share of wrong records of each event's `value` `[n_events]`.

    `log_wrong` `[n_events]` has that share in it, as `value` has.
    """
    wrong = np.exp(np.minimum(log_wrong - value, 0.0))
    odds = np.exp(log_share) / -np.expm1(log_share)
    return np.where(np.isfinite(log_wrong), wrong - (1.0 - wrong) * odds, 0.0)
