"""Effects on friction: what else than volume moves or spreads it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from avahazard.records.errors import AvahazardError
from avahazard.synth.settings import Exponential, Power
from avahazard.synth.world import WINTER_DAYS, World


def volume_law(world: World, strength: float) -> dict[str, object]:
    """Another law: log μ moves by `strength` of the way to the power law (or exponential)."""
    other = Exponential() if isinstance(world.settings.law, Power) else Power()
    base = world.settings.law.log_friction(world.volume_m3)
    world.log_mu += strength * (other.log_friction(world.volume_m3) - base)
    return {"law": type(other).__name__.lower(), "share": strength}


def volume_scatter(world: World, strength: float) -> dict[str, object]:
    """σ(V) = a' exp(-n' V), the same as in the base world at 60,000 m3."""
    n = 6e-6 * strength
    a = world.settings.scatter * float(np.exp(n * 6e4))
    world.scatter *= np.exp(-n * (world.volume_m3 - 6e4))
    return {"a": a, "n_per_m3": n}


def snow_type(world: World, strength: float) -> dict[str, object]:
    """Dry snow runs further, wet snow less far."""
    offsets = {"dry": -0.10 * strength, "mixed": 0.0, "wet": 0.13 * strength}
    world.log_mu += np.array([offsets[str(kind)] for kind in world.columns["snow_type"]])
    return {"log_mu": offsets}


def path_section(world: World, strength: float) -> dict[str, object]:
    """Channelled paths have less friction than open ones."""
    half = 0.2 * strength
    channelled = np.array([s.path.section == "channelled" for s in world.sites])[world.path]
    world.log_mu += np.where(channelled, -half, half)
    return {"log_mu": {"channelled": -half, "open": half}}


def release_elevation(world: World, strength: float) -> dict[str, object]:
    """log μ falls with the elevation of the release."""
    per_m, middle = -0.0006 * strength, 2200.0
    world.log_mu += per_m * (world.release_elevation_m - middle)
    return {"log_mu_per_m": per_m, "reference_m": middle}


def season(world: World, strength: float) -> dict[str, object]:
    """log μ rises in a straight line from 1 December to the end of April."""
    rise = 0.36 * strength
    world.log_mu += rise * (world.day / WINTER_DAYS - 0.5)
    return {"log_mu_over_winter": rise, "days": WINTER_DAYS}


def path_effect(world: World, strength: float) -> dict[str, object]:
    """Each path has its own offset of log μ."""
    tau = 0.15 * strength
    offsets = tau * world.generator("path-effect").normal(size=len(world.sites))
    world.log_mu += offsets[world.path]
    by_path = {s.path.path_id: float(o) for s, o in zip(world.sites, offsets, strict=True)}
    return {"tau": tau, "log_mu": by_path}


def covariate(column: str) -> Callable[[World, float], dict[str, object]]:
    """log μ follows a bent curve of a numeric column, which is made when there is none."""

    def apply(world: World, strength: float) -> dict[str, object]:
        if column not in world.columns:
            made = world.generator(f"covariate {column}").normal(size=len(world.path))
            world.columns[column] = np.round(made, 3)
        values = world.columns[column]
        if values.dtype.kind != "f":
            raise AvahazardError(
                f"The column {column!r} is not numeric.", "Name a numeric column, or a new one."
            )
        middle, sd = float(values.mean()), float(values.std())
        z = (values.astype(float) - middle) / sd
        world.log_mu += 0.13 * strength * (np.tanh(2.0 * z) + 0.4 * np.cos(2.0 * z))
        return {
            "log_mu": "amplitude (tanh 2z + 0.4 cos 2z), z = (column - middle) / sd",
            "amplitude": 0.13 * strength,
            "middle": middle,
            "sd": sd,
        }

    return apply
