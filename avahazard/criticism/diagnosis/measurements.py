"""How far data tell effects apart, how large one would be detected, what to measure."""

from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.special import logsumexp

from avahazard.arrays import Floats
from avahazard.criticism.diagnosis.naming import MARGIN
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.scoring.speed_misfit import friction_given_record
from avahazard.effects.effect import FrictionEffect, of_kind
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
    if first.observations.sites:
        groups = first.observations.columns.path_index
        best = max(float(np.mean(gain[groups == k])) for k in np.unique(groups))
        for key, n, places in (
            ("measure_mid_track", N_MIDDLES, 1),
            ("measure_whole_track", N_TRACKS, N_PLACES),
        ):
            found[Note(key, n=n)] = speed_gain(first, second, n, places, seed)
        found[Note("measure_further_path", n=N_EVENTS)] = N_EVENTS * best
    shifts = _column_shifts(first, second)
    if len(shifts) == 2:
        (a, shift_a), (b, shift_b) = shifts.items()
        total = float(np.median(sum(friction_variance(first))))
        # The weaker must be missed: its rival then gives it up.
        apart = 0.5 * min(float(np.var(shift_a)), float(np.var(shift_b))) / total
        found[Note("measure_unlinked", n=N_EVENTS, one=a, other=b)] = N_EVENTS * apart
    ranked = sorted(found.items(), key=lambda item: -item[1])
    return Rows(Measurement(note, float(gain)) for note, gain in ranked if gain >= LEAST_GAIN)


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


class _Expected(NamedTuple):
    """Speeds `[n_nodes, n_places]` of one event at each friction, with the chance of each."""

    speeds: Floats
    chance: Floats


def speed_gain(first: Refit, second: Refit, n_events: int, n_places: int, seed: int) -> float:
    """Mean log likelihood ratio (nats) of speeds at `n_places` along each of `n_events` tracks.

    Either fit is true in half of the simulations. Friction is known as closely as each fit knows
    it from the record; the errors are the measurement's and the model's own.
    """
    observations = first.observations
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
    x, way, length = _places(first.observations, event, n_places)
    pair = (_expected(first, event, x), _expected(second, event, x))
    # Friction scatters along the tracks as found, or as thought of before.
    found = [fit.posterior.layout.track_sigma(fit.mode.u) for fit in (first, second)]
    own = max(sigma or TRACK_SCATTER for sigma in found)
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


def _places(observations: Observations, event: int, n_places: int) -> tuple[Floats, Floats, float]:
    """Places x (m) between the release and the stop of an event, their distances, the stop's."""
    site = observations.sites[observations.columns.path_index[event]]
    release = float(site.release_x[observations.release[event]])
    stop = float(observations.observed[event])
    if observations.kind[event] == ELEVATION:
        x = site.terrain_x
        below = np.flatnonzero((site.smooth.height(x) <= stop) & (x > release))
        stop = float(x[below[0]]) if len(below) else float(x[-1])
    way = np.asarray((np.arange(n_places) + 1.0) / (n_places + 1.0), np.float64) * (stop - release)
    return release + way, way, stop - release


def _expected(fit: Refit, event: int, x: Floats) -> _Expected:
    posterior = fit.posterior
    observations, u = posterior.observations, fit.mode.u
    at = posterior.friction_at(u, posterior.mode_offsets(u))
    friction, chance = friction_given_record(posterior, posterior.nodes.at(u), event, at)
    site = observations.sites[observations.columns.path_index[event]]
    resistance = posterior.resistance(site, posterior.layout.effect_values(u))
    terrain = site.terrain_for(resistance)
    start = terrain.node(float(site.release_x[observations.release[event]]))
    kept = chance > 1e-6
    speeds = speeds_along(build_cells(terrain, resistance), start, friction[kept], x)
    return _Expected(speeds, chance[kept] / np.sum(chance[kept]))
