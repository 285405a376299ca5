"""What a file has no column for, it says nothing of: the stored value stands."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace
from typing import Any

import numpy as np

from avahazard.records import defaults
from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

ON_A_PATH = ("path_id", "runout_elevation_m", "runout_x_m", "left_profile")
ON_A_LINE = ("fall_height_m", "runout_length_m", "h_over_l")
COORDINATES = ("easting_m", "northing_m", "crs", "lon", "lat")


def complete_path(new: Path, old: Path | None, header: Collection[str]) -> Path:
    """Return `new` with the values of `old` in the columns that `header` lacks."""
    return new if old is None else replace(new, **_kept(old, new, header))


def complete_event(new: Event, old: Event | None, header: Collection[str]) -> Event:
    """Return `new` with the values of `old` in the columns that `header` lacks.

    Defaults follow what they stand on: an error by the year, a volume by the deposit.
    """
    if old is None:
        return new
    kept = _kept(old, new, header)
    # A row without a path gives its height and reach whole, in one way or another.
    for name in (*ON_A_LINE, *(ON_A_PATH if new.path_id is None else ())):
        kept.pop(name, None)
    if old.runout_sigma_m == defaults.runout_sigma_m(old.year):
        kept.pop("runout_sigma_m", None)
    of_deposit = "volume_m3" in kept and old.volume_m3 == _deposit(old)
    event: Event = replace(new, **kept)
    if "runout_sigma_m" not in kept and "runout_sigma_m" not in header:
        event = replace(event, runout_sigma_m=defaults.runout_sigma_m(event.year))
    if of_deposit or event.volume_m3 is None:
        event = replace(event, volume_m3=_deposit(event))
    return event


def complete_speed(new: Speed, old: Speed | None, header: Collection[str]) -> Speed:
    """Return `new` with the error of `old` if `header` lacks it and it was no default."""
    if old is None or "speed_sigma_m_s" in header:
        return new
    if old.speed_sigma_m_s == defaults.speed_sigma_m_s(old.speed_m_s):
        return new
    return replace(new, speed_sigma_m_s=old.speed_sigma_m_s)


def complete_profile(
    new: Profile, old: Profile | None, header: Collection[str]
) -> tuple[Profile, list[str]]:
    """Return `new` with what `header` lacks from `old`, and the columns that are lost.

    Values of points are kept where the points lie at the same distances.
    """
    if old is None:
        return new, []
    lacking = [
        name
        for name in ("land_cover", "elevation_sigma_m", *COORDINATES)
        if name not in header and getattr(old, name) is not None
    ]
    if any(name in header for name in COORDINATES):
        lacking = [name for name in lacking if name not in COORDINATES]
    if np.array_equal(new.x_m, old.x_m):
        kept: dict[str, Any] = {name: getattr(old, name) for name in lacking}
        return replace(new, **kept), []
    return new, lacking


def _kept(old: Path | Event, new: Path | Event, header: Collection[str]) -> dict[str, Any]:
    names = [f.name for f in fields(old) if f.name != "covariates" and f.name not in header]
    covariates = {c: v for c, v in old.covariates.items() if c not in header}
    return {n: getattr(old, n) for n in names} | {"covariates": covariates | dict(new.covariates)}


def _deposit(event: Event) -> float | None:
    sides = (event.deposit_length_m, event.deposit_width_m, event.deposit_thickness_m)
    known = [side for side in sides if side is not None]
    return defaults.deposit_volume_m3(*known) if len(known) == 3 else None
