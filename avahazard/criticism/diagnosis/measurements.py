"""What to measure next: by how many nats a measurement would part two explanations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.distinguishable import explained, friction_variance
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.scoring.speed_misfit import friction_given_record
from avahazard.effects.effect import FrictionEffect, of_kind
from avahazard.inference.model.layout import TRACK_SCATTER
from avahazard.inference.model.observations import ELEVATION, Observations, track_spread
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.cells import build_cells
from avahazard.physics.speed import speeds_along
from avahazard.results.base import Rows
from avahazard.results.diagnosis import Measurement

N_MIDDLES, N_TRACKS, N_PLACES = 20, 5, 8
"""Events with a speed at mid-track, or with that many along the whole track."""
N_EVENTS = 50
SPEED_SIGMA_M_S = 1.5
N_SIMULATIONS = 50
LEAST_GAIN = 0.5
"""Expected gain (nats) from which on a measurement is proposed."""


def measurement_gains(first: Refit, second: Refit, seed: int = 0) -> Rows[Measurement]:
    """Measurements that part two fits, best first, each with its expected gain (nats).

    None that gains less than `LEAST_GAIN`. Without profiles only further events can be measured.
    """
    gain = record_gain(first, second)
    found = {Note("measure_runouts", n=N_EVENTS): N_EVENTS * float(np.mean(gain))}
    if first.posterior.observations.sites:
        groups = first.posterior.observations.columns.path_index
        best = max(float(np.mean(gain[groups == k])) for k in np.unique(groups))
        found |= {
            Note("measure_mid_track", n=N_MIDDLES): speed_gain(first, second, N_MIDDLES, 1, seed),
            Note("measure_whole_track", n=N_TRACKS): speed_gain(
                first, second, N_TRACKS, N_PLACES, seed
            ),
            Note("measure_further_path", n=N_EVENTS): N_EVENTS * best,
        }
    shifts = _column_shifts(first, second)
    if len(shifts) == 2:
        (a, shift_a), (b, shift_b) = shifts.items()
        total = friction_variance(first).total
        # The weaker must be missed: its rival then gives it up.
        apart = 0.5 * min(float(np.var(shift_a)), float(np.var(shift_b))) / float(np.median(total))
        found[Note("measure_unlinked", n=N_EVENTS, one=a, other=b)] = N_EVENTS * apart
    ranked = sorted(found.items(), key=lambda item: -item[1])
    return Rows(Measurement(note, float(gain)) for note, gain in ranked if gain >= LEAST_GAIN)


def record_gain(first: Refit, second: Refit) -> Floats:
    """Expected log likelihood ratio (nats) of one more event like each `[n_events]`.

    The fits ask for different frictions; what paths differ by is not known of new ones, so only
    differences within a path tell.
    """
    gap = explained(first, second)
    groups = first.posterior.observations.columns.path_index
    for k in np.unique(groups[groups >= 0]):
        gap[groups == k] -= np.mean(gap[groups == k])
    return np.asarray(0.5 * gap**2 / friction_variance(first).total)


def _column_shifts(first: Refit, second: Refit) -> dict[str, Floats]:
    """What the effects of one fit alone do to log friction `[n_events]`.

    Only those that go by a column of the events.
    """
    shifts = {}
    for mine, other in ((first, second), (second, first)):
        values = mine.posterior.layout.effect_values(mine.mode.u)
        for effect in of_kind(mine.posterior.effects, FrictionEffect):
            if effect.key not in other.specification.effects:
                columns = effect.design(mine.posterior.observations.columns)
                shifts[effect.key] = np.asarray(columns @ values[effect.key])
    return shifts


class _Expected(NamedTuple):
    """Speeds `[n_nodes, n_places]` of one event at each friction, with the chance of each."""

    speeds: Floats
    chance: Floats


def speed_gain(first: Refit, second: Refit, n_events: int, n_places: int, seed: int) -> float:
    """Mean log likelihood ratio (nats) of speeds at `n_places` along each of `n_events` tracks.

    Either fit is true in half of the simulations. Friction is known as closely as each fit knows
    it from the record; the errors are the measurement's and the model's own.
    """
    observations = first.posterior.observations
    stopped = np.flatnonzero(
        np.isfinite(observations.observed) & (observations.columns.path_index >= 0)
    )
    if len(stopped) == 0:
        return 0.0
    chosen = stopped[np.linspace(0, len(stopped) - 1, n_events).round().astype(int)]
    rng = generator(seed, "speed gain", n_places)
    return float(sum(_event_gain(first, second, int(i), n_places, rng) for i in chosen))


def _event_gain(
    first: Refit, second: Refit, event: int, n_places: int, rng: np.random.Generator
) -> float:
    x, way, length = _places(first.posterior.observations, event, n_places)
    pair = (_expected(first, event, x), _expected(second, event, x))
    own = max(_own_error(first), _own_error(second))
    # Of squares of speed (`speed_errors`), at the mean of what both fits expect.
    mean = np.mean([fit.chance @ fit.speeds for fit in pair], axis=0)
    error = SPEED_SIGMA_M_S**2 * (4.0 * mean**2 + 2.0 * SPEED_SIGMA_M_S**2)
    spread = own**2 * track_spread(way, length)
    factor = np.asarray(np.linalg.cholesky(spread + np.diag(error)), np.float64)
    gains: list[Floats] = []
    for true, other in (pair, pair[::-1]):
        drawn = rng.choice(len(true.chance), N_SIMULATIONS, p=true.chance)
        noise = rng.standard_normal((N_SIMULATIONS, n_places)) @ factor.T
        square = true.speeds[drawn] ** 2 + noise
        gains.append(_log_density(square, true, factor) - _log_density(square, other, factor))
    return float(np.mean(gains))


def _log_density(square: Floats, expected: _Expected, factor: Floats) -> Floats:
    """Log density of squares of speed `[n_simulations, n_places]`, up to a constant."""
    misfit = square[:, None, :] - expected.speeds**2
    z = np.linalg.solve(factor, misfit.reshape(-1, len(factor)).T).T.reshape(misfit.shape)
    with np.errstate(divide="ignore"):
        log_chance = np.log(expected.chance)
    return np.asarray(logsumexp(log_chance - 0.5 * np.sum(z**2, axis=2), axis=1))


def _own_error(fit: Refit) -> float:
    """Scatter of friction along the tracks, as found or as thought of before."""
    place = fit.posterior.layout.track_scatter
    return TRACK_SCATTER if place is None else float(np.exp(fit.mode.u[place]))


def _places(observations: Observations, event: int, n_places: int) -> tuple[Floats, Floats, float]:
    """Places x (m) spread evenly between the release and the stop of an event.

    With them, their distances from the release and that of the stop.
    """
    site = observations.sites[observations.columns.path_index[event]]
    release, stop = (
        float(site.release_x[observations.release[event]]),
        float(observations.observed[event]),
    )
    if observations.kind[event] == ELEVATION:
        x = site.terrain_x
        below = np.flatnonzero((site.smooth.height(x) <= stop) & (x > release))
        stop = float(x[below[0]]) if len(below) else float(x[-1])
    share = np.asarray((np.arange(n_places) + 1.0) / (n_places + 1.0), np.float64)
    way = share * (stop - release)
    return release + way, way, stop - release


def _expected(fit: Refit, event: int, x: Floats) -> _Expected:
    posterior = fit.posterior
    observations, u = posterior.observations, fit.mode.u
    location, scatter = posterior.location_and_scatter(u)
    offsets = posterior.offsets(u).mode if posterior.plan else None
    location = posterior.shifted(location, offsets)
    of_event = location[event], scatter[event], posterior.weight(u)[event]
    friction, chance = friction_given_record(posterior, posterior.nodes.at(u), event, *of_event)
    site = observations.sites[observations.columns.path_index[event]]
    resistance = posterior.resistance(site, posterior.layout.effect_values(u))
    terrain = site.terrain_for(resistance)
    start = terrain.node(float(site.release_x[observations.release[event]]))
    kept = chance > 1e-6
    speeds = speeds_along(build_cells(terrain, resistance), start, friction[kept], x)
    return _Expected(speeds, chance[kept] / np.sum(chance[kept]))
