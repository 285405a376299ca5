"""What a world is made of, effects apart."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.records.path import Path, Profile


@dataclass(frozen=True, slots=True)
class Exponential:
    """Median friction a exp(-n V), n in 1/m3."""

    a: float = 0.5
    n: float = 7e-7

    def log_friction(self, volume_m3: Floats) -> Floats:
        """log μ at a volume in m3."""
        return np.asarray(np.log(self.a) - self.n * volume_m3)


@dataclass(frozen=True, slots=True)
class Power:
    """Median friction alpha V^-beta, V in m3."""

    alpha: float = 1.83
    beta: float = 0.12

    def log_friction(self, volume_m3: Floats) -> Floats:
        """log μ at a volume in m3."""
        return np.asarray(np.log(self.alpha) - self.beta * np.log(volume_m3))


@dataclass(frozen=True, slots=True)
class SitePlan:
    """A path, its terrain, and the events that come down it.

    Volumes are lognormal between `volume_low_m3` and `volume_high_m3`; with `pin_range`
    two of the events have just these. Releases are on steep places in the
    topmost `release_share` of the drop, which is `drop_m` or that of the profile.
    """

    path: Path
    profile: Profile
    n_events: int
    volume_median_m3: float = 6e4
    volume_log_sd: float = 1.0
    volume_low_m3: float = 2e3
    volume_high_m3: float = 8e5
    pin_range: bool = False
    release_share: float = 0.25
    drop_m: float | None = None


@dataclass(frozen=True, slots=True)
class Settings:
    """The base world.

    `scatter`: sd of log μ; `student_df`: degrees of freedom of Student's t with that scale
    (None: normal); `wrong_share`: records with a gross error; `censored_share`: events of
    a path unseen because they stop above its `observed_below_m`; `speeds`: share of events
    with measured speeds (None: none, or 0.3 where an effect needs them); `decoys`: columns
    of pure noise, in turn numeric, categorical, following volume, following release
    elevation; `smooth_m`: wavelength that a smoothing of the given profiles halves.
    """

    law: Exponential | Power = Exponential()
    scatter: float = 0.15
    student_df: float | None = None
    wrong_share: float = 0.0
    censored_share: float = 0.0
    volume_rel_sigma: float = 0.3
    speeds: float | None = None
    decoys: int = 0
    smooth_m: float = 0.0


def generator(seed: int, key: str) -> np.random.Generator:
    """Generator of the stream `key` of the world `seed`."""
    return np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(key.encode())]))
