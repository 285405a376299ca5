"""A synthetic dataset before its avalanches run: what effects read and change."""

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date, timedelta

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import ndtr, ndtri

from avahazard.arrays import Bools, Floats, Ints
from avahazard.kernels import kernel
from avahazard.records.collection import Path, Profile


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
    """The base dataset.

    `scatter`: sd of log μ; `wrong_share`: records with a gross error; `censored_share`: events of a
    path undetected because they stop above its `observed_below_m`; `speeds`: share of events with
    measured speeds (None: none, or 0.3 where an effect needs them); `decoys`: columns of pure
    noise, in turn numeric, categorical, following volume, following release elevation.
    """

    law: Exponential | Power = Exponential()
    scatter: float = 0.15
    wrong_share: float = 0.0
    censored_share: float = 0.0
    volume_rel_sigma: float = 0.3
    speeds: float | None = None
    decoys: int = 0


Sites = tuple[SitePlan, ...]


def generator(seed: int, key: str) -> np.random.Generator:
    """Generator of the stream `key` of the dataset `seed`."""
    return np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(key.encode())]))


@dataclass(slots=True)
class Track:
    """A cubic spline y(x) and the resistance in each cell between two knots.

    `knots_m [n_cells + 1]`, `coef [4, n_cells]` in rising powers of x - knot; cell arrays
    `[n_cells]`. The deceleration (m/s²) in a cell is, with u the speed, μ(u) N + constant +
    quadratic u², μ(u) = μ (r + (1 - r) / (1 + u / u0)) and N = max(0, g cosθ + centrifugal κ u²).
    """

    knots_m: Floats
    coef: Floats
    forest: Bools
    constant: Floats = field(init=False)
    quadratic: Floats = field(init=False)
    centrifugal: float = 1.0
    weakening_r: float = 1.0
    weakening_u0: float = 1.0

    def __post_init__(self) -> None:
        n = len(self.knots_m) - 1
        self.constant, self.quadratic = np.zeros(n), np.zeros(n)

    def _cell(self, x_m: Floats | float) -> tuple[Floats, Floats]:
        """How far x is into its cell, and the coefficients there."""
        i = np.clip(np.searchsorted(self.knots_m, x_m, "right") - 1, 0, len(self.forest) - 1)
        return x_m - self.knots_m[i], self.coef[:, i]

    def elevation(self, x_m: Floats | float) -> Floats:
        """Elevation at x, in metres."""
        d, c = self._cell(x_m)
        return np.asarray(c[0] + d * (c[1] + d * (c[2] + d * c[3])))

    def slope(self, x_m: Floats | float) -> Floats:
        """-dy/dx at x: the tangent of the slope angle."""
        d, c = self._cell(x_m)
        return np.asarray(-(c[1] + d * (2.0 * c[2] + d * 3.0 * c[3])))

    def place(self, elevation_m: Floats | float) -> Floats:
        """First x from the top at which the path is down to an elevation (clipped to its ends)."""
        x, y = self.fine()
        lowest_so_far = np.minimum.accumulate(y)
        return np.asarray(np.interp(-np.asarray(elevation_m), -lowest_so_far, x))

    def fine(self, step_m: float = 0.5) -> tuple[Floats, Floats]:
        """Points (x, y) along the path, close enough for straight lines between them."""
        n = max(2, int(np.ceil((self.knots_m[-1] - self.knots_m[0]) / step_m)) + 1)
        x = np.linspace(self.knots_m[0], self.knots_m[-1], n)
        return x, self.elevation(x)

    def middles(self) -> Floats:
        """Elevation in the middle of each cell `[n_cells]`, in metres."""
        return self.elevation(0.5 * (self.knots_m[1:] + self.knots_m[:-1]))

    def split(self, x_m: float) -> None:
        """Put a knot at x, so that a resistance can begin or end there; the terrain is the same."""
        i = int(np.searchsorted(self.knots_m, x_m, "right")) - 1
        d = x_m - self.knots_m[i] if 0 <= i < len(self.forest) else 0.0
        if d == 0.0:
            return
        c0, c1, c2, c3 = self.coef[:, i]
        moved = [
            c0 + d * (c1 + d * (c2 + d * c3)),
            c1 + d * (2 * c2 + d * 3 * c3),
            c2 + 3 * c3 * d,
            c3,
        ]
        self.coef = np.insert(self.coef, i + 1, moved, axis=1)
        self.knots_m = np.insert(self.knots_m, i + 1, x_m)
        for name in ("forest", "constant", "quadratic"):
            of_cells = getattr(self, name)
            setattr(self, name, np.insert(of_cells, i + 1, of_cells[i]))


def make_track(x_m: Floats, y_m: Floats, land_cover: Sequence[str] | None = None) -> Track:
    """Track through profile points `[n_points]`; a cell has the land cover of its upper point."""
    coef = CubicSpline(x_m, y_m, bc_type="natural").c[::-1]
    forest = np.array([cover == "forest" for cover in (land_cover or [""] * len(x_m))][:-1])
    return Track(np.array(x_m, float), np.ascontiguousarray(coef, float), forest)


GRAVITY = 9.81
STOPPED, LEFT_PROFILE, NOT_RELEASED = 0, 1, 2
STEP_M = 1.0


@kernel(fastmath=False)
def _rate(d, w, c, resistance, motion):  # type: ignore[no-untyped-def]
    """dw/dx at the distance d into a cell."""
    slope = c[1] + d * (2.0 * c[2] + d * 3.0 * c[3])
    root = math.sqrt(1.0 + slope * slope)
    curvature = (2.0 * c[2] + 6.0 * c[3] * d) / (root * root * root)
    w = max(w, 0.0)
    u = math.sqrt(w)
    mu, centrifugal, r, u0 = motion
    constant, quadratic = resistance
    normal = max(0.0, GRAVITY / root + centrifugal * curvature * w)
    friction = mu * (r + (1.0 - r) / (1.0 + u / u0)) * normal
    resisting = friction + constant + quadratic * w
    return 2.0 * root * (-GRAVITY * slope / root - resisting)


@kernel(fastmath=False)
def _step(d, w, h, c, resistance, motion):  # type: ignore[no-untyped-def]
    """w after one classical Runge-Kutta step of length h."""
    k1 = _rate(d, w, c, resistance, motion)
    k2 = _rate(d + 0.5 * h, w + 0.5 * h * k1, c, resistance, motion)
    k3 = _rate(d + 0.5 * h, w + 0.5 * h * k2, c, resistance, motion)
    k4 = _rate(d + h, w + h * k3, c, resistance, motion)
    return w + h * (k1 + 2.0 * (k2 + k3) + k4) / 6.0


@kernel(fastmath=False)
def _run(knots, coef, cells, x0, motion, step, w_knots):  # type: ignore[no-untyped-def]
    """One run from rest at x0: (status, x of the stop); fills w_knots where it passes."""
    i = min(max(np.searchsorted(knots, x0, "right") - 1, 0), len(knots) - 2)
    x, w = x0, 0.0
    if _rate(x - knots[i], 0.0, coef[i], (cells[0, i], cells[1, i]), motion) <= 0.0:
        return NOT_RELEASED, x
    while i < len(knots) - 1:
        resistance = (cells[0, i], cells[1, i])
        c = coef[i]
        n = max(1, math.ceil((knots[i + 1] - x) / step))
        h = (knots[i + 1] - x) / n
        d = x - knots[i]
        for k in range(n):
            at = d + k * h
            after = _step(at, w, h, c, resistance, motion)
            if after <= 0.0:
                low, high = 0.0, h
                for _ in range(40):
                    middle = 0.5 * (low + high)
                    if _step(at, w, middle, c, resistance, motion) > 0.0:
                        low = middle
                    else:
                        high = middle
                return STOPPED, knots[i] + at + high
            w = after
        i += 1
        x = knots[i]
        w_knots[i] = w
    return LEFT_PROFILE, x


def run_track(
    track: Track, release_x_m: Floats, mu: Floats, step_m: float = STEP_M
) -> tuple[Ints, Floats, Floats]:
    """Run events `[n_events]` down a track.

    Returns the status (STOPPED, LEFT_PROFILE, NOT_RELEASED), x of the stop in metres
    (the end of the profile where it was left, the release where nothing moved), and the
    speed in m/s at every knot `[n_events, n_knots]`, 0 where the block did not pass.
    """
    n = len(mu)
    status, stop = np.zeros(n, np.int64), np.zeros(n)
    w_knots = np.zeros((n, len(track.knots_m)))
    cells = np.stack([track.constant, track.quadratic])
    knots, coef = track.knots_m, np.ascontiguousarray(track.coef.T)
    same = (float(track.centrifugal), float(track.weakening_r), float(track.weakening_u0))
    starts = zip(release_x_m.tolist(), mu.tolist(), strict=True)
    for j, (x, friction) in enumerate(starts):
        motion = (friction, *same)
        status[j], stop[j] = _run(knots, coef, cells, x, motion, step_m, w_knots[j])
    return status, stop, np.sqrt(w_knots)


WINTER_DAYS = 150
STEEP = 0.8  # the tangent of a slope on which nearly all of these avalanches start


@dataclass(slots=True)
class Dataset:
    """All arrays `[n_events]` unless said; an effect changes them in place.

    There are more events than will be recorded, since some go undetected. `path` points into
    `sites` and `tracks`; `day` counts from 1 December; `log_mu` is the median of log friction and
    `scatter` the sd of what is added to it. `lead_m` is how far along the path the front is ahead
    of the centre of mass; `raised_m` how much too high a stop was written down; `unseen_share` of a
    path's events stop too high to be seen, and `limit_known` says whether that height is given.
    """

    seed: int
    settings: Settings
    sites: Sites
    tracks: list[Track]
    path: Ints
    volume_m3: Floats
    release_elevation_m: Floats
    day: Ints
    dates: list[date]
    deposit_length_m: Floats
    log_mu: Floats
    scatter: Floats
    lead_m: Floats
    raised_m: Floats
    unseen_share: float
    limit_known: bool = True
    columns: dict[str, Floats | NDArray[np.str_]] = field(default_factory=dict)

    @property
    def years(self) -> Ints:
        """Calendar year of each event."""
        return np.array([d.year for d in self.dates])

    def generator(self, key: str) -> np.random.Generator:
        """Random numbers for one purpose."""
        return generator(self.seed, key)


def draw_dataset(seed: int, sites: Sites, settings: Settings, spare: float) -> Dataset:
    """The base dataset: `spare` times the events of each site, with volumes, dates, columns."""
    path = np.repeat(np.arange(len(sites)), [int(np.ceil(spare * s.n_events)) + 6 for s in sites])
    n = len(path)
    tracks = [make_track(s.profile.x_m, s.profile.y_m, s.profile.land_cover) for s in sites]
    volume = _draw_volumes(generator(seed, "volumes"), sites, path)
    release = _draw_releases(generator(seed, "releases"), sites, tracks, path)
    rng = generator(seed, "dates")
    first = np.array([s.path.observed_from or 1900 for s in sites])[path]
    last = np.array([s.path.observed_to or 2020 for s in sites])[path]
    day = rng.integers(0, WINTER_DAYS, n)
    # A winter is named by its January; its December belongs to the year before.
    winter = rng.integers(first + 1, last + 1)
    dates = [date(int(w) - 1, 12, 1) + timedelta(int(d)) for w, d in zip(winter, day, strict=True)]
    spread = np.exp(generator(seed, "deposits").normal(0.0, 0.5, n))
    dataset = Dataset(
        seed=seed,
        settings=settings,
        sites=sites,
        tracks=tracks,
        path=path,
        volume_m3=volume,
        release_elevation_m=np.round(release, 1),
        day=day,
        dates=dates,
        deposit_length_m=10.0 * np.cbrt(volume) * spread,
        log_mu=settings.law.log_friction(volume),
        scatter=np.full(n, settings.scatter),
        lead_m=np.zeros(n),
        raised_m=np.zeros(n),
        unseen_share=settings.censored_share,
    )
    _draw_columns(dataset)
    return dataset


def _draw_volumes(rng: np.random.Generator, sites: Sites, path: Ints) -> Floats:
    uniform = rng.uniform(size=len(path))
    volume = np.empty(len(path))
    for k, s in enumerate(sites):
        selected = path == k
        ends = np.log([s.volume_low_m3, s.volume_high_m3])
        low, high = ndtr((ends - np.log(s.volume_median_m3)) / s.volume_log_sd)
        z = ndtri(low + (high - low) * uniform[selected])
        volume[selected] = s.volume_median_m3 * np.exp(s.volume_log_sd * z)
        if s.pin_range:
            volume[np.flatnonzero(selected)[:2]] = s.volume_low_m3, s.volume_high_m3
    return volume


def _draw_releases(
    rng: np.random.Generator, sites: Sites, tracks: list[Track], path: Ints
) -> Floats:
    """Elevations of steep places near the top; the steepest of the upper half without such."""
    uniform = rng.uniform(size=len(path))
    release = np.empty(len(path))
    for k, (site, track) in enumerate(zip(sites, tracks, strict=True)):
        x, y = track.fine(2.0)
        slope, drop = track.slope(x), site.drop_m or float(y.max() - y.min())
        zone = (y >= y.max() - site.release_share * drop) & (y <= y.max() - 0.02 * drop)
        steep = np.flatnonzero(zone & (slope >= STEEP))
        if not len(steep):
            upper = np.flatnonzero(y >= y.max() - 0.5 * drop)
            steep = upper[slope[upper] >= np.quantile(slope[upper], 0.8)]
        selected = path == k
        release[selected] = y[steep[(uniform[selected] * len(steep)).astype(int)]]
    return release


def _draw_columns(dataset: Dataset) -> None:
    n = len(dataset.path)
    snow = dataset.generator("snow").choice(["dry", "mixed", "wet"], size=n, p=[0.5, 0.2, 0.3])
    dataset.columns["snow_type"] = snow
    degrees = np.minimum(dataset.generator("temperature").normal(-6.0, 3.0, n), 0.0)
    dataset.columns["snow_temperature_c"] = np.asarray(np.round(degrees, 1), np.float64)
    for k in range(dataset.settings.decoys):
        rng = dataset.generator(f"decoy {k}")
        noise = rng.normal(size=n)
        name = f"decoy_{k + 1}"
        if k % 4 == 1:
            dataset.columns[name] = np.array(["x", "y", "z"])[rng.integers(0, 3, n)]
            continue
        followed = {2: np.log(dataset.volume_m3), 3: dataset.release_elevation_m}.get(k % 4)
        if followed is not None:
            noise = 0.7 * (followed - followed.mean()) / followed.std() + np.sqrt(0.51) * noise
        dataset.columns[name] = np.round(noise, 3)
