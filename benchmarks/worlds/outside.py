"""Effects that the catalogue does not have, as worlds show them.

The file of the same name in benchmarks/outside is what a user would write once the axis is known.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.effects.effect import Definition
from avahazard.effects.own_file import read_effect_file
from avahazard.synth.effects import WorldEffect
from avahazard.synth.world import World

FOLDER = Path(__file__).resolve().parents[1] / "outside"
AXES = {
    "wind_packing": "covariate:wind_m_s",
    "warm_snow": "covariate:snow_temperature_c",
    "surveyor": "covariate:surveyor",
    "warming": "covariate:year",
}
"""The axis along which each shows."""


def wind_packing(world: World, strength: float) -> dict[str, object]:
    """Friction falls in a step about a wind of 8 m/s."""
    wind = np.round(world.generator("wind").gamma(3.0, 2.3, len(world.path)), 1)
    world.columns["wind_m_s"] = wind
    world.log_mu -= 0.28 * strength / (1.0 + np.exp(-(wind - 8.0)))
    return {"log_mu": -0.28 * strength, "wind_m_s": 8.0}


def warm_snow(world: World, strength: float) -> dict[str, object]:
    """Friction falls in a line from -4 °C to 0."""
    degrees = np.asarray(world.columns["snow_temperature_c"], float)
    world.log_mu -= 0.4 * strength * np.clip((degrees + 4.0) / 4.0, 0.0, 1.0)
    return {"log_mu": -0.4 * strength}


def surveyor(world: World, strength: float) -> dict[str, object]:
    """Surveyor B writes down places that lie too high."""
    who = world.generator("surveyor").choice(["A", "B", "C"], len(world.path), p=[0.4, 0.35, 0.25])
    world.columns["surveyor"] = who
    world.raised_m += np.where(who == "B", 45.0 * strength, 0.0)
    return {"raised_m": 45.0 * strength}


def warming(world: World, strength: float) -> dict[str, object]:
    """Friction falls in a line with the years since 1950."""
    world.log_mu -= 0.005 * strength * np.maximum(world.years - 1950, 0)
    return {"log_mu_per_year": -0.005 * strength}


def proxy(world: World, strength: float) -> dict[str, object]:
    """A column that follows the elevation of the release closely and does nothing by itself."""
    z = world.release_elevation_m
    noise = world.generator("proxy").normal(0.0, 0.15 * float(np.std(z)), len(z))
    world.columns["slab_hardness"] = np.round((z + noise) / 100.0, 2)
    return {"strength": strength}


EFFECTS: dict[str, WorldEffect] = {
    "wind_packing": wind_packing,
    "warm_snow": warm_snow,
    "surveyor": surveyor,
    "warming": warming,
    "proxy": proxy,
}


def effect_file(name: str) -> Definition:
    """The effect that a user would write."""
    return read_effect_file(FOLDER / f"{name}.py").definition
