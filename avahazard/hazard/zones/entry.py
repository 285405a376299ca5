"""What one path has by its avalanches: speeds, pressures, chances and zones, as plain values."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.exceedance import Reach, exceeded_runout, reach
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import QUANTILES
from avahazard.hazard.zones.exceeded_speeds import exceeded_speeds
from avahazard.hazard.zones.limits import Limits
from avahazard.hazard.zones.pieces import Exceeded, ZonePiece, zone_pieces
from avahazard.hazard.zones.pressure import draw_densities, pressure_kpa
from avahazard.inference.seeds import generator

Floats = NDArray[np.float64]

N_PLACES = 81
HELD_WORTH_A_NOTE = 0.05
"""Share of avalanches that stop at their release from which it is said."""
INTERVAL = (
    "speed and pressure that a year exceeds with chance 1/T, all volumes and frictions mixed: 5, "
    "50 and 95 % over the uncertainty of the parameters, of the frequency and of the density"
)


def path_zones(
    path: PathHazard,
    limits: Limits,
    periods: Sequence[float],
    density: tuple[float, float],
    extrapolated: Collection[float],
    seed: int,
) -> dict[str, Any]:
    """The entry of `zones` for one path.

    `periods` (years) rise and hold those of the limits; `density` is the mean of the flow and its
    standard deviation, kg/m3; `extrapolated` are the periods that the record is too short for.
    """
    avalanches = path.avalanches
    rng = generator(seed, "density", path.path_id)
    densities = draw_densities(*density, avalanches.n_parameters, rng)
    chances = reach(avalanches, N_PLACES)
    speeds = exceeded_speeds(avalanches, chances.x, periods)
    pressures = pressure_kpa(densities, speeds)
    exceeded = {
        period: Exceeded(exceeded_runout(avalanches, period), pressures[k])
        for k, period in enumerate(periods)
    }
    pieces = zone_pieces(limits, chances.x, exceeded)
    # [n_periods, 3, n_places]
    speed = np.quantile(speeds, QUANTILES, axis=1).swapaxes(0, 1)
    pressure = np.quantile(pressures, QUANTILES, axis=1).swapaxes(0, 1)
    entry: dict[str, Any] = {
        "path_id": path.path_id,
        "limits": limits.name,
        "density_kg_m3": {"mean": density[0], "sd": density[1]},
        "release_x_m": float(chances.x[0]),
        "end_x_m": float(chances.x[-1]),
        "interval": INTERVAL,
        "places": [
            {
                "x_m": float(chances.x[i]),
                "elevation_m": float(chances.elevation[i]),
                "p_reach_per_year": float(chances.chance[i, 1]),
                "by_return_period": [
                    {
                        "return_period_years": period,
                        "extrapolated": period in extrapolated,
                        "speed_m_s": _quantiles(speed[k, :, i]),
                        "pressure_kpa": _quantiles(pressure[k, :, i]),
                    }
                    for k, period in enumerate(periods)
                ],
            }
            for i in range(len(chances.x))
        ],
        "p_not_released": _held(avalanches, chances),
        "zones": [
            _zone(piece, any(r.return_period_years in extrapolated for r in zone.rules))
            for piece, zone in zip(pieces, limits.zones, strict=True)
        ],
    }
    return {**entry, "notes": _notes(entry, [p for p in periods if p in extrapolated])}


def _quantiles(values: Floats) -> dict[str, float]:
    low, middle, high = values
    return {"q05": float(low), "q50": float(middle), "q95": float(high)}


def _held(avalanches: Avalanches, chances: Reach) -> float:
    """Median share of avalanches that stop at their release, by the first place below it."""
    started = -np.log1p(-chances.chance[1, 1])
    return float(np.clip(1.0 - started / np.median(avalanches.volumes.rate), 0.0, 1.0))


def _zone(piece: ZonePiece, extrapolated: bool) -> dict[str, Any]:
    return {
        "zone": piece.name,
        "color": piece.color,
        "from_x_m": piece.from_x,
        "to_x_m": piece.to_x,
        "to_x_q05_m": piece.to_x_q05,
        "to_x_q95_m": piece.to_x_q95,
        "beyond": piece.beyond,
        "extrapolated": extrapolated,
    }


def _notes(entry: dict[str, Any], extrapolated: Sequence[float]) -> list[str]:
    notes = []
    if extrapolated:
        far = ", ".join(f"{period:g}" for period in extrapolated)
        notes.append(
            f"{entry['path_id']}: T = {far} is past twice the observed years, or past "
            "the table of volumes: an extrapolation."
        )
    if entry["p_not_released"] > HELD_WORTH_A_NOTE:
        notes.append(
            f"{entry['path_id']}: {entry['p_not_released']:.0%} of the avalanches stop at their "
            "release, where the slope is under the friction. Give the path a release_elevation_m "
            "on steeper ground."
        )
    return notes
