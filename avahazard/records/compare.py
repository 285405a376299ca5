"""Whether two records say the same, number by number."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from avahazard.records.event import Event, Speed
from avahazard.records.path import Path, Profile

Difference = tuple[str, object, object]  # column, one value, the other value


def differences(one: Path | Event | Speed, other: Path | Event | Speed) -> list[Difference]:
    """Return the columns in which `one` and `other` differ; numbers are compared exactly."""
    found: list[Difference] = []
    for name in (f.name for f in fields(one)):
        left, right = getattr(one, name), getattr(other, name)
        if name == "covariates":
            for column in {**left, **right}:
                if left.get(column) != right.get(column):
                    found.append((column, left.get(column), right.get(column)))
        elif left != right:
            found.append((name, left, right))
    return found


def profile_difference(one: Profile, other: Profile) -> tuple[int, Difference] | None:
    """Return the first point at which two profiles differ and how, None when they are equal."""
    n = min(len(one.x_m), len(other.x_m))
    first: tuple[int, Difference] | None = None
    for name in (f.name for f in fields(Profile)):
        left, right = getattr(one, name), getattr(other, name)
        if name == "path_id" or left is right:
            continue
        place: int | None
        if left is None or right is None:
            place = 0
        elif isinstance(left, str):
            place = None if left == right else 0
        else:
            unequal = np.nonzero(np.asarray(left[:n]) != np.asarray(right[:n]))[0]
            place = int(unequal[0]) if len(unequal) else None
        if place is not None and (first is None or place < first[0]):
            first = (place, (name, _at(left, place), _at(right, place)))
    if first is None and len(one.x_m) != len(other.x_m):
        first = (n - 1, ("path_id", f"{len(one.x_m)} points", f"{len(other.x_m)} points"))
    return first


def _at(values: object, place: int) -> object:
    if isinstance(values, str) or values is None:
        return values
    return values[place]  # type: ignore[index]
