"""Future avalanches on a path: where they start, and what they are like.

Releases follow a Beta distribution along the release zone, after Eckert, Parent and others (2007
on), who draw the release from the records' distribution. What spreads recorded releases is nature
and the error of the records: future avalanches have the spread without the error.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import beta

from avahazard.arrays import Floats, Ints
from avahazard.effects.columns import RELEASE_SIGMA, EventColumns, build_columns, counted
from avahazard.effects.effect import known
from avahazard.effects.site import Site
from avahazard.inference.model.observations import release_elevations, released_site
from avahazard.inference.model.release_errors import stated_release_sigma
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Event, Records, of_path

MAX_CLASSES = 24
"""Recorded events, at most, that an avalanche to come may be like."""
ENOUGH_RELEASES = 5
LEAST_SPREAD_M = 20.0
"""Recorded releases within this range are taken for one place."""
N_RELEASES = 8


@dataclass(frozen=True, slots=True)
class ReleaseZone:
    """Elevations from `low_m` to `high_m`, Beta(a, b) between them; the top of a path at most."""

    low_m: float
    high_m: float
    a: float
    b: float

    def elevations(self, n: int = N_RELEASES) -> Floats:
        """Elevations (m) `[n]` in the middle of n equally probable parts, lowest first."""
        share = beta.ppf((np.arange(n) + 0.5) / n, self.a, self.b)
        return np.asarray(self.low_m + (self.high_m - self.low_m) * share)


def release_zone(
    elevations: Floats, top_m: float, sigma: Floats | float = 0.0
) -> ReleaseZone | None:
    """Fit the zone to recorded releases (m) `[n]` of a path whose top is at `top_m`.

    `sigma` `[n]` (m) are their errors, of which they are freed first (`without_error`).
    The zone reaches the mean spacing of the records past their lowest and highest, the top at
    most; a and b are those with the mean and variance of the records. None with under 5
    records or where they spread over less than 20 m: then the path's own release is the one.
    """
    n = len(elevations)
    if n < ENOUGH_RELEASES or np.ptp(elevations) < LEAST_SPREAD_M:
        return None
    elevations = without_error(elevations, sigma)
    spacing = float(np.ptp(elevations)) / (n - 1)
    low = float(np.min(elevations)) - spacing
    high = min(float(np.max(elevations)) + spacing, max(top_m, float(np.max(elevations))))
    share = (np.asarray(elevations) - low) / (high - low)
    mean, variance = float(np.mean(share)), float(np.var(share, ddof=1))
    # Beta's variance is under mean (1 - mean): at the limit all mass lies at the ends.
    strength = max(mean * (1.0 - mean) / variance - 1.0, 0.1)
    return ReleaseZone(low, high, mean * strength, (1.0 - mean) * strength)


def without_error(elevations: Floats, sigma: Floats | float) -> Floats:
    """Recorded releases (m) `[n]` drawn towards their mean, so that they spread as the true ones.

    The true variance is that of the records less the mean square of their errors, at least that
    of one place.
    """
    mean, recorded = float(np.mean(elevations)), float(np.var(elevations, ddof=1))
    true = max(recorded - float(np.mean(np.square(sigma))), LEAST_SPREAD_M**2 / 12.0)
    return np.asarray(mean + np.sqrt(min(true / recorded, 1.0)) * (elevations - mean))


def stated_zone(elevation_m: float, sigma_m: float) -> ReleaseZone | None:
    """The zone a path states: uniform, of that mean and sd (m); None where it is one place."""
    side = float(np.sqrt(3.0)) * sigma_m
    if 2.0 * side < LEAST_SPREAD_M:
        return None
    return ReleaseZone(elevation_m - side, elevation_m + side, 1.0, 1.0)


def path_release_zone(records: Records, path_id: str) -> ReleaseZone | None:
    """The release zone of a path from its records, None where they tell of one place only.

    Recorded releases are freed of their errors. Where too few are recorded it is what the path
    states of its zone, the error of its own release.
    """
    selected = of_path(records, path_id)
    ((path,), (profile,)) = selected.paths, selected.profiles
    top = float(np.max(profile.y_m))
    recorded = [e for e in selected.events if e.release_elevation_m is not None]
    if len(recorded) < ENOUGH_RELEASES:
        stated = path.covariates.get(RELEASE_SIGMA)
        own = top if path.release_elevation_m is None else path.release_elevation_m
        return stated_zone(own, float(stated)) if isinstance(stated, int | float) else None
    elevations = [e.release_elevation_m for e in recorded]
    sigma = stated_release_sigma(recorded, {path_id: path})
    return release_zone(np.array(elevations, np.float64), top, sigma)


def classes_to_come(
    records: Records, path_id: str, volume_m3: float, *, event_columns: bool
) -> tuple[Event, ...]:
    """Events of this volume that an avalanche to come on the path may be, equally likely.

    They start along the release zone of the path's records, or where the path says. With
    `event_columns` they are like the path's recorded ones (those of all paths, where it has none)
    in these; volume, release and columns know nothing of each other.
    """
    zone = path_release_zone(records, path_id)
    models: list[Event] = []
    if event_columns:
        models = list(of_path(records, path_id).events)
        models = models or [e for e in records.events if e.path_id is not None]
        kept = np.linspace(0, len(models) - 1, min(len(models), MAX_CLASSES)).round().astype(int)
        models = [models[k] for k in np.unique(kept)]
    models = models or [Event("")]
    releases: list[float | None] = [None] * len(models)
    if zone is not None:
        # Every column meets several releases.
        models = models * -(-N_RELEASES // len(models))
        order = generator(0, "releases to come", path_id).permutation(len(models))
        releases = [float(z) for z in zone.elevations(len(models))[order]]
    return tuple(
        Event(
            f"to come {k}",
            path_id,
            model.date,
            release_elevation_m=release,
            volume_m3=volume_m3,
            deposit_length_m=model.deposit_length_m,
            covariates=model.covariates,
        )
        for k, (model, release) in enumerate(zip(models, releases, strict=True))
    )


@dataclass(frozen=True, slots=True, eq=False)
class FutureEvents:
    """Classes of future avalanches, equally frequent; `release` indexes `site.release_x`."""

    site: Site
    release: Ints
    columns: EventColumns

    @property
    def n_classes(self) -> int:
        """Number of classes."""
        return len(self.release)

    def at_volumes(self, volume: Floats) -> EventColumns:
        """The columns of every class once for each volume (m3) `[n_volumes]`."""
        rows = np.repeat(np.arange(self.n_classes), len(volume))
        log_volume = np.tile(np.log(volume), self.n_classes)
        return replace(self.columns.at(rows), log_volume=log_volume)


def classes_of(there: Records, among: EventColumns) -> FutureEvents:
    """The events of one path as classes of future avalanches, each for one `among` these.

    They come in the last winter of these: what has changed since the records began has changed.
    """
    ((path,), (profile,)), events = (there.paths, there.profiles), there.events
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    site, release = released_site(path, profile, smooth, events)
    elevation = release_elevations(site)[release]
    columns = build_columns(events, {path.path_id: path}, elevation)
    columns = replace(columns, made=counted(columns, among))
    winters = known(among.winter)
    if len(winters):
        latest = float(np.max(winters))
        ahead = np.nan_to_num(latest - columns.winter)
        year = np.where(np.isfinite(columns.year), columns.year + ahead, latest)
        day, winter = columns.day + 365.2425 * ahead, np.full(len(events), latest)
        columns = replace(columns, year=year, day=day, winter=winter)
    return FutureEvents(site, release, columns)
