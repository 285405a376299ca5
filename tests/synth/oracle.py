"""What one gains who knows the hidden effect: log likelihood with it less that without."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import logsumexp

from avahazard.records.collection import Records
from avahazard.synth.dataset import Settings, Track, draw_dataset, run_track
from avahazard.synth.effects import find_effect
from avahazard.synth.making import ahead, make_sites, uphill
from tests.synth.datasets import dataset, truth_column

COARSE = np.linspace(np.log(0.12), np.log(1.1), 50)
FINE = np.linspace(COARSE[0], COARSE[-1], 500)
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(15)


def gain(seed: int, key: str, n_events: int = 250, n_paths: int = 10) -> float:
    """Gain in nats; the law, the scatter and a path effect are fitted on both sides."""
    records, truth = dataset(seed, n_events=n_events, n_paths=n_paths, effects={key: 1.0})
    told = truth["effects"][key]["parameters"]
    base = draw_dataset(seed, make_sites(seed, n_paths, n_events), Settings(), 1.2)
    hidden = draw_dataset(seed, make_sites(seed, n_paths, n_events), Settings(), 1.2)
    find_effect(key)(hidden, 1.0)
    if key == "centrifugal":
        find_effect(key)(base, 0.0)
    length = np.array([e.deposit_length_m for e in records.events])
    early = np.array([(e.year or 0) < told.get("before_year", 0) for e in records.events])
    offset = np.log(truth_column(truth, "mu_median"))
    offset -= Settings().law.log_friction(truth_column(truth, "volume_m3"))
    spread = truth_column(truth, "scatter") / Settings().scatter
    nothing = np.zeros(n_events)
    lead = told.get("lead_per_deposit_length", 0.0) * length
    with_it = _Fit(records, truth, hidden.tracks, lead, told.get("raised_m", 0.0) * early)
    without = _Fit(records, truth, base.tracks, nothing, nothing)
    if key == "path-effect":
        # The path effect itself: none against one.
        return without.best(nothing, nothing + 1.0) - without.best(
            nothing, nothing + 1.0, tau=False
        )
    limits = truth["seen_below_m"] if key == "observation-limit" else None
    return with_it.best(offset, spread, limits=limits) - without.best(nothing, nothing + 1.0)


class _Fit:
    """Likelihood of the records over a grid of log friction, `[n_events, n_grid]`."""

    def __init__(
        self, records: Records, truth: dict[str, Any], tracks: list[Track], lead: Any, raised: Any
    ) -> None:
        self.volume = truth_column(truth, "volume_m3")
        ids = [p.path_id for p in records.paths]
        self.ids = [e.path_id or "" for e in records.events]
        self.path = np.array([ids.index(path_id) for path_id in self.ids])
        self.stop = np.empty((len(self.path), len(FINE)))
        self.likelihood = np.empty_like(self.stop)
        speeds: dict[str, list[Any]] = {}
        for s in records.speeds:
            speeds.setdefault(s.event_id, []).append(s)
        self.in_x = np.zeros(len(self.path), bool)
        for i, event in enumerate(records.events):
            track = tracks[self.path[i]]
            release = np.full(len(COARSE), float(track.place(event.release_elevation_m or 0.0)))
            _, x, u = run_track(track, release, np.exp(COARSE), 4.0)
            front = ahead(track, x, np.full(len(x), lead[i]))
            left = np.interp(FINE, COARSE, front >= track.knots_m[-1] - 1e-9) > 0.5
            y = track.elevation(front)
            recorded_x = uphill(track, front, np.full(len(x), raised[i]))
            profile = records.profiles[self.path[i]]
            self.in_x[i] = bool((np.diff(profile.y_m) >= 0.0).any())
            self.stop[i] = np.interp(FINE, COARSE, y)
            place = recorded_x if self.in_x[i] else track.elevation(recorded_x)
            found = event.runout_x_m if self.in_x[i] else event.runout_elevation_m
            if event.left_profile or found is None:
                self.likelihood[i] = left
            else:
                z = (found - np.interp(FINE, COARSE, place)) / event.runout_sigma_m
                self.likelihood[i] = np.where(left, 0.0, np.exp(-0.5 * z**2) / event.runout_sigma_m)
            for s in speeds.get(event.event_id, []):
                at = u[:, int(np.argmin(np.abs(track.knots_m - s.x_m)))]
                z = (np.interp(FINE, COARSE, at) - s.speed_m_s) / s.speed_sigma_m_s
                self.likelihood[i] *= np.exp(np.maximum(-0.5 * z**2, -60.0))

    def best(
        self, offset: Any, spread: Any, tau: bool = True, limits: dict[str, float] | None = None
    ) -> float:
        """Largest log likelihood over log a, n, σ and the sd of the paths."""
        likelihood, seen = self.likelihood, np.ones_like(self.likelihood)
        if limits is not None:
            seen = self.stop <= np.array([limits[i] for i in self.ids])[:, None]
            likelihood = likelihood * seen

        def minus_log(theta: Any) -> float:
            log_a, n, log_sigma, log_tau = theta
            middle = log_a - n * 1e-6 * self.volume + offset
            sigma = (np.exp(log_sigma) * spread)[:, None]
            each = np.empty((len(self.path), len(NODES)))
            for j, node in enumerate(NODES):
                shift = np.exp(log_tau) * node if tau else 0.0
                density = np.exp(-0.5 * ((FINE - (middle + shift)[:, None]) / sigma) ** 2) / sigma
                told = (density * likelihood).sum(axis=1)
                # A floor for records that no friction explains, the same on both sides.
                share = (density * seen).sum(axis=1) / density.sum(axis=1)
                each[:, j] = np.log(told / np.maximum(share, 1e-9) + 1e-9)
            by_path = [
                logsumexp(each[self.path == k].sum(axis=0), b=WEIGHTS) for k in set(self.path)
            ]
            # A weak prior keeps the sd of the paths off zero.
            return -float(np.sum(by_path)) + 0.5 * (log_tau - np.log(0.1)) ** 2

        start = [np.log(0.5), 0.7, np.log(0.17), np.log(0.05)]
        options = {"maxiter": 260, "xatol": 1e-3, "fatol": 0.02}
        return -float(minimize(minus_log, start, method="Nelder-Mead", options=options).fun)
