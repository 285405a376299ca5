"""What to measure next: how many nats a measurement would part two explanations by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avahazard.criticism.refits import Refit
from avahazard.inference.mode import likely_friction
from avahazard.inference.seeds import generator
from avahazard.inference.study import Study
from avahazard.physics.cells import build_cells
from avahazard.physics.speed import speeds_along

Floats = NDArray[np.float64]

N_TRACKS, N_EVENTS = 20, 50
SPEED_SIGMA_M_S = 1.5
N_SIMULATIONS = 100


def measurement_gains(first: Refit, second: Refit, seed: int = 0) -> list[dict[str, object]]:
    """Measurements that part two fits, best first, each with its expected gain (nats).

    Without profiles only further events can be measured.
    """
    events = {
        "measurement": f"runouts of {N_EVENTS} more events on paths like these",
        "expected_gain": record_gain(first, second) * N_EVENTS,
    }
    if not first.posterior.study.sites:
        return [events]
    result = [
        {
            "measurement": f"speeds at mid-track on {N_TRACKS} events",
            "expected_gain": speed_gain(first, second, seed),
        },
        events,
        {
            "measurement": f"{N_EVENTS} events on a further path, steeper or longer than these",
            "expected_gain": _unlike_gain(first, second) * N_EVENTS,
        },
    ]
    return sorted(result, key=lambda r: -float(str(r["expected_gain"])))


def speed_gain(first: Refit, second: Refit, seed: int) -> float:
    """Mean log likelihood ratio of simulated speeds at mid-track, either fit being true.

    Friction is the one that each fit gives the event's record, so that only the speed parts
    them.
    """
    study = first.posterior.study
    stopped = np.flatnonzero(np.isfinite(study.observed) & (study.columns.path_index >= 0))
    if len(stopped) == 0:
        return 0.0
    chosen = stopped[np.linspace(0, len(stopped) - 1, N_TRACKS).round().astype(int)]
    a, b = _mid_speeds(first, chosen), _mid_speeds(second, chosen)
    rng = generator(seed, "speed gain")
    gains = []
    for _ in range(N_SIMULATIONS):
        noise = SPEED_SIGMA_M_S * rng.standard_normal(len(a))
        for true, other in ((a, b), (b, a)):
            measured = true + noise
            ratio = ((measured - other) ** 2 - (measured - true) ** 2) / SPEED_SIGMA_M_S**2
            gains.append(0.5 * float(np.sum(ratio)))
    return float(np.mean(gains))


def _mid_speeds(fit: Refit, events: NDArray[np.int64]) -> Floats:
    posterior = fit.posterior
    study: Study = posterior.study
    friction = likely_friction(posterior.nodes_at(fit.mode.u), posterior.layout.log_scatter)
    values = posterior.layout.effect_values(fit.mode.u)
    speeds = np.empty(len(events))
    for k, i in enumerate(events):
        site = study.sites[study.columns.path_index[i]]
        resistance = posterior.resistance(site, values)
        terrain = site.terrain_for(resistance)
        cells = build_cells(terrain, resistance)
        release = site.release_x[study.release[i]]
        table = site.smooth
        stop = study.observed[i]
        if study.kind[i] == 0:
            x = terrain.x
            below = np.flatnonzero((table.height(x) <= stop) & (x > release))
            stop = float(x[below[0]]) if len(below) else float(x[-1])
        middle = 0.5 * (release + stop)
        mu = np.array([friction[i]])
        speeds[k] = speeds_along(cells, terrain.node(release), mu, np.array([middle]))[0, 0]
    return speeds


def record_gain(first: Refit, second: Refit) -> float:
    """Present gap of the log likelihoods per event: what one more such event brings."""
    return abs(first.log_likelihood - second.log_likelihood) / first.posterior.study.n_events


def _unlike_gain(first: Refit, second: Refit) -> float:
    """The gap per event on the path where the two part most."""
    posterior = first.posterior
    gap = _by_event(first) - _by_event(second)
    groups = posterior.study.columns.path_index
    means = [abs(float(np.mean(gap[groups == k]))) for k in np.unique(groups)]
    return max(means)


def _by_event(fit: Refit) -> Floats:
    offsets = None
    if fit.posterior.groups is not None:
        offsets = fit.posterior.path_offsets(fit.mode.u).mode
    return fit.posterior.event_log_likelihood(fit.mode.u, offsets)
