"""Volumes from snowfall: the three-day snow depth of a return period over the release area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.gev import Gev
from avahazard.hazard.shape_grid import gev_draws, gev_likelihood, shape_prior
from avahazard.hazard.volume_frequency import N_DRAWS, VolumeFrequency
from avahazard.hazard.volume_record import VolumeRecord
from avahazard.records.errors import AvahazardError

FEWEST_WINTERS = 10
DEPTH_SHAPE, DEPTH_SHAPE_SD = 0.0, 0.15
"""Weak prior of the shape of yearly largest three-day depths."""
LEAST_DEPTH_M = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class SnowfallDraws:
    """Yearly largest depths as `gev` (m); a volume is `m3_per_m` times a depth.

    The year's avalanche releases the year's depth: a volume comes as often as its depth. But no
    more avalanches come than the path's `rate` `[n]`.
    """

    gev: Gev
    m3_per_m: float
    rate: Floats

    def rate_over(self, log_volume: Floats) -> Floats:
        """Of a Poisson process whose yearly maxima are those depths, at most `rate`."""
        exceeded = self.gev.exceedance(np.exp(log_volume) / self.m3_per_m)
        with np.errstate(divide="ignore"):
            return np.minimum(-np.log1p(-exceeded), self.rate[:, None])

    def log_volume(self, chance: float) -> Floats:
        """The depth that a year exceeds with this chance, as a volume."""
        depth = np.maximum(self.gev.quantile(1.0 - chance), LEAST_DEPTH_M)
        return np.asarray(np.log(depth * self.m3_per_m))

    def ends(self) -> tuple[float, float]:
        """From depths that most years exceed to those of 10,000 years."""
        middle = np.quantile(self.log_volume(0.98), 0.2)
        return float(middle), float(np.quantile(self.log_volume(1e-4), 0.9))


def snowfall_frequency(
    path_id: str,
    depths_m: Floats,
    release_area_m2: float,
    density_ratio: float,
    record: VolumeRecord | None,
    rng: np.random.Generator,
) -> VolumeFrequency:
    """Frequency from the largest three-day snow depth of each winter (m) `[n_winters]`.

    V = depth · release area · `density_ratio` (density of the release over that of the deposit).
    The rate is that of `record`, or one avalanche a year without one. Raises `AvahazardError`
    with under 10 winters, or where all are equal.
    """
    if len(depths_m) < FEWEST_WINTERS or np.ptp(depths_m) == 0.0:
        raise AvahazardError(
            f"{len(depths_m)} winters of snow depth are too few for path {path_id}, "
            "or all are equal.",
            f"Give the largest three-day depth of {FEWEST_WINTERS} winters at least.",
        )
    # The grid's scales are those of logs: depths are brought to a spread of one.
    unit = float(np.std(depths_m))
    sample = depths_m / unit
    prior = shape_prior(DEPTH_SHAPE, DEPTH_SHAPE_SD)
    drawn = gev_draws(sample, prior, gev_likelihood(sample), N_DRAWS, rng)
    gev = Gev(drawn.shape, drawn.location * unit, drawn.scale * unit)
    rate = np.ones(N_DRAWS)
    if record is not None:
        rate = rng.gamma(record.n_events + 0.5, 1.0 / record.n_years, N_DRAWS)
    text = (
        f"GEV of three-day snow depth, {len(depths_m)} winters, posterior; "
        f"{release_area_m2:.4g} m2 of release, density ratio {density_ratio:g}"
    )
    if record is None:
        text += "; one avalanche a year, for want of a record"
    return VolumeFrequency(
        path_id=path_id,
        draws=SnowfallDraws(gev, release_area_m2 * density_ratio, rate),
        method=text,
        pooled=False,
        record=record,
        longest_years=len(depths_m),
        source="snow",
    )
