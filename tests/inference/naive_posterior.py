"""The likelihood of observations as it is written down: sums over fine grids, event by event."""

from __future__ import annotations

import numpy as np
from scipy import stats

from avahazard.effects.effect import FrictionEffect, KindsEffect, LimitEffect
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH
from avahazard.physics.block import LEFT_PROFILE
from avahazard.physics.runout_curve import MU
from tests.inference.naive_nodes import fine

VOLUME_Z = np.linspace(-5.0, 5.0, 21)
OFFSET_Z = np.linspace(-5.0, 5.0, 41)
"""Every half and every quarter of a standard deviation: such sums of smooth functions are exact."""


class NaivePosterior:
    """Likelihoods at coordinates u `[n_slots]`.

    `masses` hold for each event fine frictions ν (log μ, or μ for normal scatter) and what each
    adds to p(record) = Σ mass p(ν); `sights` likewise for the chance to be seen, or None.
    """

    def __init__(self, posterior: Posterior, u) -> None:
        self.posterior, self.u = posterior, u
        self.tables = posterior.nodes.predicted_at(u)
        self.values = posterior.layout.effect_values(u)
        grid = np.log(MU) if posterior.layout.log_scatter else MU
        self.grid = grid
        self.nu, self.width = fine(grid, 24)
        middles = 0.5 * (grid[1:] + grid[:-1])
        self.nearest = np.searchsorted(middles, self.nu)
        limit = posterior.observations.limit
        for effect in posterior.effects:
            if isinstance(effect, LimitEffect):
                limit = effect.limit(posterior.observations.columns, self.values[effect.key])
        n = posterior.observations.n_events
        declared = posterior.observations.limit
        self.masses = [self._mass(i, declared[i]) for i in range(n)]
        seen = ~np.isnan(limit) & (posterior.observations.columns.path_index >= 0)
        self.sights = [
            self._sight(i, limit[i], bool(np.isfinite(declared[i]))) if seen[i] else None
            for i in range(n)
        ]

    def events(self, shift: float = 0.0):
        """Log likelihood of each event with `shift` added to all log frictions."""
        result = np.empty(len(self.masses))
        for i, (mass, sight) in enumerate(zip(self.masses, self.sights, strict=True)):
            result[i] = np.log(np.sum(mass[1] * self._density(i, mass[0], shift)))
            if sight is not None:
                result[i] -= np.log(np.sum(sight[1] * self._density(i, sight[0], shift)))
            if self.posterior.specification.tails == "student":
                share = float(np.exp(self.u[self.posterior.layout.wrong_share]))
                wrong = self._wrong(i)
                if wrong > 0.0:
                    result[i] = np.log((1.0 - share) * np.exp(result[i]) + share * wrong)
        return result

    def _wrong(self, i: int) -> float:
        """Density of record i and its speeds, were it grossly wrong."""
        observations = self.posterior.observations
        if observations.kind[i] == LEFT:
            return 0.0
        if observations.kind[i] == LENGTH:
            return 1.0 / (10.0 * float(observations.fall_height[i]))
        terrain = observations.sites[observations.columns.path_index[i]].terrain
        line = terrain.y if observations.kind[i] == ELEVATION else terrain.x
        density = 1.0 / float(np.ptp(line))
        for track in observations.speeds:
            if track.event == i:
                start = np.interp(track.release_x, terrain.x, terrain.y)
                fallen = start - np.interp(track.x, terrain.x, terrain.y)
                density /= float(np.prod(np.sqrt(2.0 * 9.81 * fallen)))
        return density

    def by_paths(self, tau: float) -> float:
        """Log likelihood, the offset of every path summed over its normal distribution."""
        groups = self.posterior.observations.columns.path_index
        weight = stats.norm.pdf(OFFSET_Z) * (OFFSET_Z[1] - OFFSET_Z[0])
        logs = np.array([self.events(tau * z) for z in OFFSET_Z])
        total = float(np.sum(self.events()[groups < 0]))
        for k in range(int(groups.max()) + 1):
            path = logs[:, groups == k].sum(axis=1)
            total += float(np.log(np.sum(weight * np.exp(path - path.max()))) + path.max())
        return total

    def _mass(self, i: int, limit: float):
        observations, left = self.posterior.observations, self.tables.status[i] == LEFT_PROFILE
        if observations.kind[i] == LEFT:
            mass = self.width * left[self.nearest]
        else:
            f = np.interp(self.nu, self.grid, self.tables.record[i])
            stays = ~np.repeat(left[:-1] & left[1:], 24)
            mass = (
                self.width
                * stays
                * stats.norm.pdf(observations.observed[i], f, observations.sigma[i])
            )
        for measured, block in zip(observations.speeds, self.tables.speeds, strict=True):
            if measured.event == i:
                log_speed = self._log_speed(measured, block.speed)
                mass = mass * np.exp(np.interp(self.nu, self.grid, log_speed))
        if np.isfinite(limit):
            mass = mass * self._below(i, limit)
        return self.nu[mass > 0.0], mass[mass > 0.0]

    def _below(self, i: int, limit: float):
        """Whether frictions stop at the declared limit or below, or leave."""
        left = self.tables.status[i] == LEFT_PROFILE
        place = self.tables.elevation[i] - self.tables.raised[i]
        gone = np.repeat(left[:-1] & left[1:], 24)
        return gone | (np.interp(self.nu, self.grid, place) <= limit)

    def _sight(self, i: int, limit: float, declared: bool):
        if declared:
            return self.nu, self.width * self._below(i, limit)
        y, sigma = self.tables.elevation[i], self.posterior.observations.sigma[i]
        left = self.tables.status[i] == LEFT_PROFILE
        chance = np.where(left, 1.0, stats.norm.cdf((limit - y) / sigma))
        return self.nu, self.width * np.interp(self.nu, self.grid, chance)

    def _log_speed(self, measured, predicted):
        own = float(np.exp(self.u[self.posterior.layout.track_scatter]))
        padded = np.pad(measured.speed, 1, constant_values=np.nan)
        middle = np.nanmean([padded[:-2], padded[1:-1], padded[2:]], axis=0)
        error = 4.0 * middle**2 * measured.sigma**2 + 2.0 * measured.sigma**4
        covariance = np.diag(error) + own**2 * measured.spread
        law = stats.multivariate_normal(np.zeros(len(measured.x)), covariance)
        square = measured.speed**2 - measured.sigma**2
        jacobian = 0.5 * np.sum(np.log(error / measured.sigma**2))
        return law.logpdf(square - predicted**2) + jacobian

    def _density(self, i: int, nu, shift: float):
        """p(ν) of event i, summed over its volume."""
        layout, volumes = self.posterior.layout, self.posterior.observations.volumes
        weight = stats.norm.pdf(VOLUME_Z) / np.sum(stats.norm.pdf(VOLUME_Z))
        total = np.zeros(len(nu))
        kinds = [(1.0, 0.0)]
        for effect in self.posterior.effects:
            if isinstance(effect, KindsEffect):
                share, apart = self.values[effect.key]
                kinds = [(1.0 - share, -share * apart), (share, (1.0 - share) * apart)]
        of_each = [(h * k, z, d) for h, z in zip(weight, VOLUME_Z, strict=True) for k, d in kinds]
        for h, z, of_kind in of_each:
            volume = np.exp(volumes.mean[i : i + 1] + volumes.sd[i] * z)
            law = layout.law
            middle = float(law.log_friction(self.u[: len(law.coordinates)], volume)[0])
            middle += shift + of_kind
            for effect in self.posterior.effects:
                if isinstance(effect, FrictionEffect):
                    design = effect.design(self.posterior.observations.columns)[i]
                    middle += float(design @ self.values[effect.key])
            log_scatter = self.u[layout.scatter]
            if layout.scatter_slope is not None:
                slope = self.u[layout.scatter_slope]
                log_scatter -= slope * min(volume[0] / layout.reference_volume, 1.0)
            if not layout.log_scatter:
                middle = np.exp(middle)
            t = (nu - middle) / np.exp(log_scatter)
            if self.posterior.specification.tails == "student":
                shape = 0.375 * (1.0 + 0.25 * t**2) ** -2.5
            else:
                shape = np.exp(-0.5 * t**2) / np.sqrt(2.0 * np.pi)
            total += h * shape / np.exp(log_scatter)
        return total
