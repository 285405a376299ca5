"""Synthetic datasets of effects of the catalogue, with a held-out quarter of the winters.

They are those of `avahazard synth`, whose integrator is not the product's. Datasets of an even seed
have an effect of full strength, those of an odd seed of half.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.synth.dataset import Settings
from avahazard.synth.effects import CATALOGUE
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_records
from benchmarks.worlds.beyond import N_EVENTS, N_PATHS, held_out_winters


@dataclass(frozen=True, slots=True)
class Arm:
    """`effects` by strength and `settings` of a dataset; keys as in `beyond.Arm`."""

    effects: Mapping[str, float] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)
    right: tuple[str, ...] = ()
    neutral: tuple[str, ...] = ()


COLUMN = "covariate:new_snow_cm"
ARMS: dict[str, Arm] = {
    **{
        f"catalogue: {key}": Arm({key: 1.0}, right=(key,), neutral=("path-effect",))
        for key in (*CATALOGUE, COLUMN)
    },
    "null: scatter by volume": Arm({"volume-scatter": 1.0}, neutral=("volume-scatter",)),
    "null: undeclared limits": Arm(
        settings=Settings(censored_share=0.3), neutral=("observation-limit",)
    ),
    "null: decoy columns": Arm(settings=Settings(decoys=8)),
}


def make(name: str, seed: int, folder: Path) -> dict[str, Any]:
    """Write a dataset of an arm, `held_out/` in it; return its truth.

    `without` are effects of the base model that it must not have.
    """
    arm = ARMS[name]
    strength = 0.5 if arm.right and seed % 2 else 1.0
    effects = {key: strength * x for key, x in arm.effects.items()}
    records, _ = make_dataset(seed, N_EVENTS, N_PATHS, effects, arm.settings)
    dates = [str(event.date) for event in records.events]
    winter = np.array([int(d[:4]) + (int(d[5:7]) >= 10) for d in dates], np.int64)
    out = held_out_winters(np.random.default_rng(seed), winter)
    events = np.array(records.events, dtype=object)
    train = {event.event_id for event in events[~out]}
    speeds = tuple(s for s in records.speeds if s.event_id in train)
    (folder / "held_out").mkdir(parents=True)
    write_records(folder, replace(records, events=tuple(events[~out]), speeds=speeds))
    write_records(folder / "held_out", replace(records, events=tuple(events[out]), speeds=()))
    without = [key for key in effects if key == "centrifugal"]
    return {"right": list(arm.right), "neutral": list(arm.neutral), "without": without}
