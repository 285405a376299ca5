"""Records of the datasets of `sbc_worlds`, all of them but what is drawn from a model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from avahazard.inference.model.observations import Observations, build_observations
from avahazard.records.collection import Event, Path, Profile, Records, Speed
from tests.inference.studies import SNOW, profile

VOLUME_SPREAD = 1.0
SPEED_ERROR = 2.0


@dataclass(frozen=True, slots=True)
class Case:
    """A model and the records of its datasets.

    `a` is the friction about which they lie, `volume` (m3) the median of the recorded volumes,
    `volume_error` their relative error. With `dropped` releases lie up to so many metres below the
    top. With `seen_below` stops above so many metres (on the first path; the others lie higher)
    are undetected; with the effect `observation-limit` no record lies above them, and it is known
    from how far above none would be seen. Along every other event speeds are measured at the places
    `speeds` (m). Errors of records (m) lie between the two of `record_error`. `n_worlds` are made.
    """

    effects: tuple[str, ...] = ()
    n_events: int = 40
    n_paths: int = 2
    a: float = 0.55
    law: str = "exponential"
    centrifugal: bool = True
    volume: float = float(np.exp(10.5))
    volume_error: float = 1e-6
    dropped: float = 0.0
    seen_below: float | None = None
    speeds: tuple[float, ...] = ()
    record_error: tuple[float, float] = (10.0, 25.0)
    n_worlds: int = 100

    def highest_seen(self, k: int) -> float | None:
        """Elevation (m) that `seen_below` is on path `k`."""
        return None if self.seen_below is None else self.seen_below + 60.0 * (k % 6)


@cache
def _ground(case: Case) -> tuple[tuple[Path, ...], tuple[Profile, ...]]:
    """Bowls, every other one cut short, so that some events leave it."""
    whole = [profile(k % 6) for k in range(case.n_paths)]
    cut = [np.where(p.x_m <= (1450.0, 1900.0)[k % 2])[0] for k, p in enumerate(whole)]
    names = [f"P{k}" for k in range(case.n_paths)]
    declared = "observation-limit" not in case.effects
    return (
        tuple(
            Path(
                name,
                section=("channelled", "open")[k % 2],
                observed_below_m=case.highest_seen(k) if declared else None,
            )
            for k, name in enumerate(names)
        ),
        tuple(
            Profile(name, p.x_m[c], p.y_m[c], tuple(np.array(p.land_cover)[c]))
            for name, p, c in zip(names, whole, cut, strict=True)
        ),
    )


def groups(n_events: int) -> dict[str, np.ndarray]:
    """Labels of winters and storms: two of three events fell in pairs, two pairs a winter."""
    i = np.arange(n_events)
    storm = np.where(i < 2 * n_events // 3, i // 2, i)
    winter = np.where(i < 2 * n_events // 3, i // 4, i)
    return {"winter-effect": winter, "storm-effect": storm}


def _date(i: int, n_events: int) -> str:
    """A day of the winter and storm of an event; days of a storm are one apart."""
    of = groups(n_events)
    winter, storm = int(of["winter-effect"][i]), int(of["storm-effect"][i])
    month = ("12", "02", "04")[storm % 2 if i < 2 * n_events // 3 else i % 3]
    # A December belongs to the winter that ends in the next year.
    return f"{1921 + winter - (month == '12')}-{month}-{10 + i % 2:02d}"


def without_stops(case: Case, rng: np.random.Generator) -> Observations:
    """Events with all columns and no stop yet, errors of the stops to come, places of speeds."""
    n = case.n_events
    recorded = case.volume * np.exp(VOLUME_SPREAD * rng.standard_normal(n))
    paths, profiles = _ground(case)
    wind = rng.standard_normal(n)
    events = tuple(
        Event(
            f"e{i}",
            paths[i % case.n_paths].path_id,
            date=_date(i, n),
            left_profile=True,
            release_elevation_m=float(profiles[i % case.n_paths].y_m[0])
            - case.dropped * (i // case.n_paths % 4) / 3.0,
            volume_m3=float(v),
            volume_rel_sigma=case.volume_error,
            deposit_length_m=30.0 + 3.0 * (i * 7 % 40),
            covariates={"snow_type": SNOW[i * 7 % 5], "wind": float(wind[i])},
        )
        for i, v in enumerate(recorded)
    )
    speeds = tuple(
        Speed(f"e{i}", 0.0, SPEED_ERROR, x_m=x)
        for i in range(n)
        if i // case.n_paths % 2
        for x in case.speeds
    )
    given = build_observations(Records(paths, profiles, events, speeds))
    return replace(given, sigma=rng.uniform(*case.record_error, n))
