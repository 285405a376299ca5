"""How far data tell effects apart, how large one would be detected, what to measure."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from operator import itemgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.special import logsumexp

from avahazard.arrays import Floats, Ints
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.scoring.speed_misfit import friction_given_record
from avahazard.effects.effect import FrictionEffect, of_kind
from avahazard.effects.pairs import columns_of_pair
from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.layout import TRACK_SCATTER
from avahazard.inference.model.observations import ELEVATION, LEFT, Observations, track_spread
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.cells import build_cells
from avahazard.physics.speed import speeds_along
from avahazard.results.base import Rows
from avahazard.results.diagnosis import Measurement

TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""


def explained(fit: Refit, base: Refit) -> Floats:
    """What an effect changes of log friction that is left over: the base model's less the fit's."""
    return _residual(base) - _residual(fit)


def _residual(fit: Refit) -> Floats:
    """Log friction that each record asks for less what the law gives `[n_events]`."""
    posterior = fit.posterior
    nodes = posterior.nodes.at(fit.mode.u)
    asked = np.log(np.maximum(likely_friction(nodes, posterior.layout.log_scatter), 1e-3))
    given, _ = posterior.location_and_scatter(fit.mode.u)
    mean = np.sum(given * posterior.weight(fit.mode.u), axis=1)
    if not posterior.layout.log_scatter:
        mean = np.log(np.maximum(mean, 1e-3))
    # An event beyond the profile has no apparent friction.
    return np.asarray(np.nan_to_num(asked - mean))


def correlation(first: Floats, second: Floats, posterior: Posterior) -> float:
    """Correlation of two changes once law and paths have taken their part (least squares)."""
    volume = np.exp(posterior.observations.volumes.mean)
    groups = posterior.observations.columns.path_index
    nuisance = np.column_stack(
        [np.ones(len(volume)), volume / np.mean(volume), np.log(volume)]
        + [groups == k for k in np.unique(groups)[1:]]
    ).astype(float)

    def rest(values: Floats) -> Floats:
        return np.asarray(values - nuisance @ np.linalg.lstsq(nuisance, values, rcond=None)[0])

    a, b = rest(first), rest(second)
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 1e-12 else 0.0


def friction_variance(fit: Refit) -> tuple[Floats, Floats]:
    """Variance of log friction of each event `[n_events]` at the mode, by scatter and record.

    The record's error counts 0 beyond the profile, where no one friction is known; normal scatter
    is taken relative to its middle.
    """
    posterior = fit.posterior
    location, scatter = posterior.location_and_scatter(fit.mode.u)
    nodes = posterior.nodes.at(fit.mode.u)
    place = nodes.place
    if not posterior.layout.log_scatter:
        scatter = scatter / np.maximum(location, 1e-3)
        place = np.log(np.maximum(place, 1e-3))
    mean = np.sum(place * nodes.weight, axis=1, keepdims=True)
    record = np.sum(nodes.weight * (place - mean) ** 2, axis=1)
    record = np.where(nodes.is_probability, 0.0, np.maximum(record, 0.0))
    return np.mean(scatter**2, axis=1), record


class Detectable(NamedTuple):
    """The smallest effect that is detectable: rms of log friction, metres (or H/L), and a share.

    The share is that of all that scatters log friction, errors of the records included: over 1
    where even more than that could be missed.
    """

    log_friction: float
    metres: float
    share: float


def detectable(base: Refit, critical_gain: float) -> Detectable:
    """The smallest effect that is detectable with 80 % power (docs/theory/criticism.md).

    Its gain must pass `critical_gain`, and be worth `MARGIN` after the price of one more parameter.
    """
    observations = base.observations
    stopped = observations.kind != LEFT
    scatter, record = friction_variance(base)
    information = float(np.sum(1.0 / (scatter + record)[stopped]))
    price = 0.5 * float(np.log1p(information * TYPICAL_SD**2))
    gain = max(critical_gain, MARGIN + price)
    shift = (np.sqrt(2.0 * gain) + float(stats.norm.ppf(0.8))) / np.sqrt(information)
    # The record's spread in metres against that in log friction gives metres per unit.
    sigma = observations.recorded_sigma(base.posterior.record_sigma(base.mode.u))
    ratio = sigma[stopped] / np.sqrt(np.maximum(record[stopped], 1e-8))
    return Detectable(
        log_friction=float(shift),
        metres=float(shift * np.median(ratio)),
        share=float(shift**2 * information / np.count_nonzero(stopped)),
    )


N_ALIKE = 5
"""Recorded events that a kind of avalanche must have: those to come are like them."""
N_TRACKS, N_PLACES, N_DRAWS = 3, 8, 8
"""Recorded events of a path that stand for those to come, and places along it that are tried;
draws of the parameters."""
SPEED_SIGMA_M_S, VOLUME_SIGMA, STOP_SIGMA_M = 1.5, 0.1, 1.0
"""Errors of what is measured (of a volume, of its log)."""
N_SIMULATIONS = 50
LEAST_GAIN = 0.05
"""Expected gain (nats) in one avalanche from which on a measurement is proposed."""


class Tried(NamedTuple):
    """A measurement: what is measured, its gain (nats) in one avalanche, and its note.

    `quantity` is a key of the days in the field; `key` and `values` are those of the note but for
    `n`.
    """

    quantity: str
    gain: float
    key: str
    values: Mapping[str, Any] = MappingProxyType({})


def measurement_gains(
    explanations: Mapping[str, Refit], field_days: Mapping[str, float], seed: int = 0
) -> Rows[Measurement]:
    """What distinguishes each pair of explanations by `MARGIN`, the fewest days in the field first.

    Of each quantity what takes fewest avalanches, none under `LEAST_GAIN` in one. `explanations`
    are fits by the effect that they add, "" being the model itself; `field_days` are those of one
    avalanche by quantity. Without profiles no speed can be measured.
    """
    tracks = tracks_of(next(iter(explanations.values())).observations)
    expected = {key: expected_speeds(fit, tracks) for key, fit in explanations.items()}
    found = []
    for (one, first), (other, second) in combinations(explanations.items(), 2):
        between = tuple(key for key in (one, other) if key)
        tried = [*_events(first, second), *_surveys(first, second)]
        # Friction scatters along the tracks as found, or as thought of before.
        scatter = max(
            f.posterior.layout.track_sigma(f.mode.u) or TRACK_SCATTER for f in (first, second)
        )
        rng = generator(seed, "speed gain", *between)
        speeds = expected[one], expected[other]
        tried += _speeds(first.observations, tracks, speeds, scatter, rng)
        for quantity in field_days:
            of_quantity = [t for t in tried if t.quantity == quantity]
            best = max(of_quantity, key=lambda t: t.gain, default=None)
            if best and best.gain >= LEAST_GAIN:
                n = int(np.ceil(MARGIN / best.gain))
                note, place = Note(best.key, n=n, **best.values), best.values
                where = place.get("path"), place.get("x")
                row = Measurement(note, n * best.gain, between, n * field_days[quantity], *where)
                found.append((n * field_days[quantity], -n * best.gain, row))
    return Rows(row for *_, row in sorted(found, key=itemgetter(0, 1)))


def _events(first: Refit, second: Refit) -> Iterator[Tried]:
    """Runouts of further events, of any kind and of each that columns distinguish."""
    gain, columns = record_gain(first, second), first.observations.columns

    def of(chosen: NDArray[np.bool_], key: str, **values: Any) -> Iterator[Tried]:
        if np.count_nonzero(chosen) >= N_ALIKE:
            yield Tried("runout", float(np.mean(gain[chosen])), key, values)

    yield from of(np.ones(len(gain), bool), "measure_runouts")
    for k, path in enumerate(columns.paths):
        yield from of(columns.path_index == k, "measure_on_path", path=path)
    for column, levels in columns.texts.items():
        for level in np.unique(levels[levels != ""]).tolist():
            yield from of(levels == level, "measure_of_level", column=column, level=level)
    for column, values in (("volume_m3", np.exp(columns.log_volume)), *columns.numbers.items()):
        if np.isfinite(values).any():
            thirds = np.nanquantile(values, (1 / 3, 2 / 3))
            low, high = (float(f"{value:.3g}") for value in thirds)
            yield from of(values < low, "measure_under", column=column, value=low)
            yield from of(values > high, "measure_over", column=column, value=high)
    shifts = _column_shifts(first, second)
    # A pair of columns cannot vary apart from one of them.
    if len(shifts) == 2 and not any(map(columns_of_pair, shifts)):
        total = float(np.median(sum(friction_variance(first))))
        # The weaker must be missed: its rival then gives it up.
        apart = 0.5 * min(float(np.var(shift)) for shift in shifts.values()) / total
        yield Tried("runout", apart, "measure_unlinked")


def _surveys(first: Refit, second: Refit) -> Iterator[Tried]:
    """Volumes and stops recorded as before and surveyed too: that shows what errors they have."""
    volumes = [fit.posterior.volumes(fit.mode.u) for fit in (first, second)]
    one, other = (v.population.factor * v.records.sigma for v in volumes)
    yield Tried("volume", _error_gain(one, other, VOLUME_SIGMA), "measure_volumes")
    if not first.observations.in_ratio:
        one, other = (f.posterior.record_sigma(f.mode.u) for f in (first, second))
        yield Tried("runout", _error_gain(one, other, STOP_SIGMA_M), "measure_stops")


def _error_gain(one: Floats, other: Floats, sigma: float) -> float:
    """Gain of errors that are seen but for `sigma`; either fit's `[n_events]` are the true ones."""
    ratio = (one**2 + sigma**2) / (other**2 + sigma**2)
    return float(np.nansum(ratio + 1.0 / ratio - 2.0)) / (4.0 * len(ratio))


def record_gain(first: Refit, second: Refit) -> Floats:
    """Expected log likelihood ratio (nats) of one more event like each `[n_events]`.

    The fits ask for different frictions; what paths differ by is not known of new ones, so only
    differences within a path tell.
    """
    gap = explained(first, second)
    groups = first.observations.columns.path_index
    for k in np.unique(groups[groups >= 0]):
        gap[groups == k] -= np.mean(gap[groups == k])
    return np.asarray(0.5 * gap**2 / sum(friction_variance(first)))


def _column_shifts(first: Refit, second: Refit) -> dict[str, Floats]:
    """What effects on friction by a column, of one fit alone, do to log friction `[n_events]`."""
    shifts = {}
    for selected, other in ((first, second), (second, first)):
        values = selected.posterior.layout.effect_values(selected.mode.u)
        for effect in of_kind(selected.posterior.effects, FrictionEffect):
            if effect.key not in other.specification.effects:
                columns = effect.design(selected.observations.columns)
                shifts[effect.key] = np.asarray(columns @ values[effect.key])
    return shifts


class PassedTrack(NamedTuple):
    """Places x `[n_places]` (m) along a path (by number), and recorded events that pass them.

    Of each event its number, and where it was released and stopped (m).
    """

    path: int
    x: Floats
    events: list[tuple[int, float, float]]


class Speeds(NamedTuple):
    """Speeds `[n, n_places]` of one event at each friction and draw, with the chance of each."""

    speeds: Floats
    chance: Floats


def tracks_of(observations: Observations) -> list[PassedTrack]:
    """A track of each path on which an event stopped; the longer half of its events pass it."""
    tracks = []
    columns, site_of = observations.columns, observations.sites
    for k in range(len(columns.paths) if site_of else 0):
        on = np.isfinite(observations.observed) & (columns.path_index == k)
        events = sorted((_way(observations, int(i)) for i in np.flatnonzero(on)), key=itemgetter(2))
        if passing := events[len(events) // 2 :]:
            chosen = passing[:: -(-len(passing) // N_TRACKS)]
            start = max(release for _, release, _ in chosen)
            x = np.linspace(start, chosen[0][2], N_PLACES + 2)[1:-1]
            tracks.append(PassedTrack(k, x, chosen))
    return tracks


def _way(observations: Observations, event: int) -> tuple[int, float, float]:
    site = observations.sites[observations.columns.path_index[event]]
    release = float(site.release_x[observations.release[event]])
    stop = float(observations.observed[event])
    if observations.kind[event] == ELEVATION:
        x = site.terrain_x
        below = np.flatnonzero((site.smooth.height(x) <= stop) & (x > release))
        stop = float(x[below[0]]) if len(below) else float(x[-1])
    return event, release, stop


def expected_speeds(fit: Refit, tracks: Sequence[PassedTrack]) -> dict[int, Speeds]:
    """What a fit expects of the speeds of the tracks' events, over its posterior.

    Friction is known as closely as the record lets the fit know it.
    """
    posterior, observations = fit.posterior, fit.observations
    found: dict[int, list[Speeds]] = {event: [] for t in tracks for event, *_ in t.events}
    for u in fit.sample[:: -(-len(fit.sample) // N_DRAWS)] if tracks else ():
        at, nodes = posterior.friction_at(u, posterior.mode_offsets(u)), posterior.nodes_at(u)
        for track in tracks:
            site = observations.sites[track.path]
            resistance = posterior.resistance(site, posterior.layout.effect_values(u))
            terrain = site.terrain_for(resistance)
            cells = build_cells(terrain, resistance)
            for event, release, _ in track.events:
                friction, chance = friction_given_record(posterior, nodes, event, at)
                kept = chance > 1e-4
                speeds = speeds_along(cells, terrain.node(release), friction[kept], track.x)
                found[event].append(Speeds(speeds, chance[kept]))
    return {
        event: Speeds(np.concatenate([d.speeds for d in draws]), chance / np.sum(chance))
        for event, draws in found.items()
        for chance in [np.concatenate([d.chance for d in draws])]
    }


def _speeds(
    observations: Observations,
    tracks: Sequence[PassedTrack],
    pair: tuple[dict[int, Speeds], dict[int, Speeds]],
    scatter: float,
    rng: np.random.Generator,
) -> Iterator[Tried]:
    """Speeds at each of the places along each path, and at all of them at once."""
    for track in tracks:
        each = [
            speed_gains((pair[0][e[0]], pair[1][e[0]]), track.x, e, scatter, rng)
            for e in track.events
        ]
        gains, path = np.mean(each, axis=0), observations.columns.paths[track.path]
        yield Tried("track", float(gains[-1]), "measure_track", {"path": path})
        z = observations.sites[track.path].smooth.height(track.x)
        for place, height, gain in zip(track.x.tolist(), z.tolist(), gains.tolist(), strict=False):
            yield Tried("speed", gain, "measure_speed", {"path": path, "x": place, "z": height})


def speed_gains(
    pair: tuple[Speeds, Speeds],
    x: Floats,
    event: tuple[int, float, float],
    scatter: float,
    rng: np.random.Generator,
) -> Floats:
    """Mean log likelihood ratio (nats) of the speed of one event at each x, and of all of them.

    `[n_x + 1]`. Either of the `pair` is true in half of the simulations; the errors are the
    measurement's and the model's own, whose friction scatters along the track by `scatter`.
    """
    _, release, stop = event
    # Of squares of speed (`speed_errors`), at the mean of what both fits expect.
    mean = np.mean([fit.chance @ fit.speeds for fit in pair], axis=0)
    error = SPEED_SIGMA_M_S**2 * (4.0 * mean**2 + 2.0 * SPEED_SIGMA_M_S**2)
    spread = scatter**2 * track_spread(x - release, stop - release) + np.diag(error)
    places, gains = np.arange(len(x)), np.zeros(len(x) + 1)
    for k, some in enumerate((*places[:, None], places)):
        factor = np.asarray(np.linalg.cholesky(spread[np.ix_(some, some)]), np.float64)
        for true, other in (pair, pair[::-1]):
            drawn = rng.choice(len(true.chance), N_SIMULATIONS, p=true.chance)
            noise = rng.standard_normal((N_SIMULATIONS, len(some))) @ factor.T
            square = true.speeds[np.ix_(drawn, some)] ** 2 + noise
            apart = [_log_density(square, fit, some, factor) for fit in (true, other)]
            gains[k] += 0.5 * float(np.mean(apart[0] - apart[1]))
    return gains


def _log_density(square: Floats, expected: Speeds, places: Ints, factor: Floats) -> Floats:
    """Log density of squares of speed `[n_simulations, n_places]`, up to a constant."""
    misfit = square[:, None, :] - expected.speeds[:, places] ** 2
    z = np.linalg.solve(factor, misfit.reshape(-1, len(factor)).T).T.reshape(misfit.shape)
    return np.asarray(logsumexp(np.log(expected.chance) - 0.5 * np.sum(z**2, axis=2), axis=1))
