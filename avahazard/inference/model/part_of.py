"""A part of the observations: some events, with the sites that they ran on."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from avahazard.arrays import Ints
from avahazard.inference.model.observations import Observations


def part_of(observations: Observations, events: Ints) -> Observations:
    """These `events` `[n]`, in this order, of observations without speeds.

    Volumes are read in the light of all, as they were.
    """
    assert not observations.speeds
    n, path = observations.n_events, observations.columns.path_index[events]
    known = np.unique(path[path >= 0])

    def rows(value: Any) -> Any:
        if isinstance(value, np.ndarray) and len(value) == n:
            return value[events]
        return value

    def of(record: Any, **own: Any) -> Any:
        """A dataclass with the rows of these events in all its columns."""
        told = {f.name: rows(getattr(record, f.name)) for f in fields(record) if f.init}
        return replace(record, **{**told, **own})

    columns, volumes = observations.columns, observations.volumes
    part: Observations = of(
        observations,
        sites=tuple(observations.sites[k] for k in known),
        columns=replace(
            columns.at(events),
            paths=tuple(columns.paths[k] for k in known),
            path_index=np.where(path >= 0, np.searchsorted(known, path), -1),
        ),
        volumes=of(
            volumes,
            records=of(
                volumes.records,
                path=tuple(volumes.records.path[i] for i in events),
                paths=tuple(columns.paths[k] for k in known),
            ),
        ),
    )
    return part


def whole_paths(observations: Observations, at_once: int) -> list[Ints]:
    """Events of all paths, whole paths together, in parts of some `at_once`."""
    path = observations.columns.path_index
    order = np.argsort(path, kind="stable")
    # A part ends with the path of its last event.
    ends = np.searchsorted(path[order], path[order][at_once - 1 :: at_once], side="right")
    return [part for part in np.split(order, np.unique(ends)) if len(part)]
