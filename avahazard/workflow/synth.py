"""Make a world with known effects, on disk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any, cast

from avahazard.results.made import MadeWorld
from avahazard.synth.making import make_world
from avahazard.synth.world import Settings
from avahazard.synth.writing import PART_PATHS, refuse_full, write_region, write_world


def synthesise(
    folder: FilePath,
    effects: Sequence[str] = (),
    *,
    strength: float = 1.0,
    n_events: int = 240,
    n_paths: int = 9,
    speeds: float | None = None,
    seed: int = 0,
) -> MadeWorld:
    """Write a world into `folder` and return what was made; all effects have one strength.

    `speeds` is the share of events with measured speeds; None gives them where an effect needs
    them. Many paths are made and written in parts . Raises `AvahazardError` where
    the folder is not empty, an effect is unknown, or nothing runs.
    """
    refuse_full(folder)
    wanted = seed, n_events, n_paths, dict.fromkeys(effects, strength), Settings(speeds=speeds)
    if n_paths > PART_PATHS:
        return write_region(folder, *wanted)
    records, truth = make_world(*wanted)
    files = write_world(folder, records, truth)
    return MadeWorld(
        folder=str(folder),
        files=tuple(str(file) for file in files),
        seed=seed,
        effects=cast(dict[str, Any], truth["effects"]),
        n_paths=len(records.paths),
        n_events=len(records.events),
        n_left_profile=sum(event.left_profile for event in records.events),
        n_speeds=len(records.speeds),
    )
