"""What one path has by its avalanches: speeds, pressures, chances and zones."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.design import design_of
from avahazard.hazard.exceedance import Reach, exceeded_runout, reach
from avahazard.hazard.notes import RELEASE_HINT
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import QUANTILES
from avahazard.hazard.zones.exceeded_speeds import exceeded_speeds
from avahazard.hazard.zones.limits import Limits
from avahazard.hazard.zones.pieces import Exceeded, zone_pieces
from avahazard.hazard.zones.pressure import draw_densities, pressure_kpa
from avahazard.inference.seeds import generator
from avahazard.message import message
from avahazard.results.base import Rows
from avahazard.results.hazard import Quantiles
from avahazard.results.zones import Density, ExceededHere, PeriodDesign, Place, ZonedPath

N_PLACES = 81
HELD_WORTH_A_NOTE = 0.05
"""Share of avalanches that stop at their release from which it is said."""
FAR = message(
    "T = {periods} is past twice the observed years, or past the table of volumes: an "
    "extrapolation."
)
HELD = message(
    "{share} of the avalanches stop at their release, where the slope is under the friction. {hint}"
)
INTERVAL = message(
    "speed and pressure that a year exceeds with chance 1/T, all volumes and frictions mixed: 5, "
    "50 and 95 % over the uncertainty of the parameters, of the frequency and of the density"
)


def path_zones(
    path: PathHazard,
    limits: Limits,
    periods: Sequence[float],
    density: Density,
    extrapolated: Collection[float],
    seed: int,
) -> ZonedPath:
    """Speeds, pressures, chances and zones of one path.

    `periods` (years) rise and hold those of the limits; `density` is that of the flow;
    `extrapolated` are the periods that the record is too short for.
    """
    avalanches = path.avalanches
    rng = generator(seed, "density", path.path_id)
    densities = draw_densities(density.mean, density.sd, avalanches.n_parameters, rng)
    chances = reach(avalanches, N_PLACES)
    speeds = exceeded_speeds(avalanches, chances.x, periods)
    pressures = pressure_kpa(densities, speeds)
    exceeded = {
        period: Exceeded(exceeded_runout(avalanches, period), pressures[k], period in extrapolated)
        for k, period in enumerate(periods)
    }
    # [n_periods, 3, n_places]
    speed = np.quantile(speeds, QUANTILES, axis=1).swapaxes(0, 1)
    pressure = np.quantile(pressures, QUANTILES, axis=1).swapaxes(0, 1)
    held = _held(avalanches, chances)
    return ZonedPath(
        path_id=path.path_id,
        limits=limits.name,
        density_kg_m3=density,
        release_x_m=float(chances.x[0]),
        end_x_m=float(chances.x[-1]),
        interval=INTERVAL,
        designs=Rows(
            PeriodDesign(period, found.extrapolated, design_of(path, found.runout_x))
            for period, found in exceeded.items()
        ),
        places=Rows(
            Place(
                x_m=float(chances.x[i]),
                elevation_m=float(chances.elevation[i]),
                p_reach_per_year=float(chances.chance[i, 1]),
                by_return_period=Rows(
                    ExceededHere(
                        return_period_years=period,
                        extrapolated=period in extrapolated,
                        speed_m_s=Quantiles(*speed[k, :, i].tolist()),
                        pressure_kpa=Quantiles(*pressure[k, :, i].tolist()),
                    )
                    for k, period in enumerate(periods)
                ),
            )
            for i in range(len(chances.x))
        ),
        p_not_released=held,
        zones=zone_pieces(limits, chances.x, exceeded),
        notes=_notes(path.path_id, held, [p for p in periods if p in extrapolated]),
    )


def _held(avalanches: Avalanches, chances: Reach) -> float:
    """Median share of avalanches that stop at their release, by the first place below it."""
    started = -np.log1p(-chances.chance[1, 1])
    return float(np.clip(1.0 - started / np.median(avalanches.volumes.rate), 0.0, 1.0))


def _notes(path_id: str, held: float, extrapolated: Sequence[float]) -> tuple[str, ...]:
    notes = []
    if extrapolated:
        far = ", ".join(f"{period:g}" for period in extrapolated)
        notes.append(f"{path_id}: {FAR.format(periods=far)}")
    if held > HELD_WORTH_A_NOTE:
        notes.append(f"{path_id}: {HELD.format(share=f'{held:.0%}', hint=RELEASE_HINT)}")
    return tuple(notes)
