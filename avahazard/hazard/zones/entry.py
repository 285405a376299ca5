"""What one path has by its avalanches: speeds, pressures p = ρ u², chances and zones."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.avalanches import Avalanches
from avahazard.hazard.exceedance import Reach, exceeded_runout, reach
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.rows import design_of
from avahazard.hazard.runout_bounds import QUANTILES, spread
from avahazard.hazard.zones.exceeded_speeds import exceeded_speeds
from avahazard.hazard.zones.limits import Rule, ZoneSystem
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.results.base import Rows
from avahazard.results.hazard import Quantiles
from avahazard.results.zones import Density, ExceededHere, PeriodDesign, Place, Zone, ZonedPath


def draw_densities(mean: float, sd: float, n: int, rng: np.random.Generator) -> Floats:
    """Flow densities `[n]` in kg/m3: lognormal with this mean and standard deviation."""
    variance = np.log1p((sd / mean) ** 2)
    noise = rng.standard_normal(n)
    return np.asarray(np.exp(np.log(mean) - 0.5 * variance + np.sqrt(variance) * noise))


def pressure_kpa(density: Floats, speed: Floats) -> Floats:
    """ρ u² in kPa.

    Of `density` `[n_parameters]` (kg/m3) and `speed` `[..., n_parameters, n_places]` (m/s).
    """
    return np.asarray(density[:, None] * speed**2 / 1000.0)


@dataclass(frozen=True, slots=True, eq=False)
class Exceeded:
    """What is exceeded once in one return period, by posterior draw.

    `runout_x` (m) `[n_parameters]`, inf past the end of the profile; `pressure_kpa`
    `[n_parameters, n_places]`, 0 past the runout. `extrapolated`: the record is too short for the
    return period.
    """

    runout_x: Floats
    pressure_kpa: Floats
    extrapolated: bool = False


def zone_pieces(limits: ZoneSystem, x: Floats, exceeded: Mapping[float, Exceeded]) -> Rows[Zone]:
    """Every zone of the limits, the worst first, from its upper to its lower end.

    `x` (m) `[n_places]` run from the release to the end of the profile; `exceeded` is by return
    period. A zone ends at the farthest place where one of its rules, or of a worse zone's, holds:
    what lies above such a place is in the zone too, as the track of an avalanche is, also where a
    steep reach follows a flat one. A zone that no draw in two has begins and ends at one place.
    Ends are medians over the posterior.
    """
    ends = np.full(len(next(iter(exceeded.values())).runout_x), x[0])
    zones = []
    start = float(x[0])
    for zone in limits.zones:
        for rule in zone.rules:
            ends = np.maximum(ends, _farthest(rule, x, exceeded[rule.return_period_years]))
        found = spread(ends)
        end = float(x[-1]) if found.q50 is None else found.q50
        zones.append(
            Zone(
                zone=zone.name,
                color=zone.color,
                from_x_m=start,
                to_x_m=end,
                to_x_q05_m=found.q05,
                to_x_q95_m=found.q95,
                beyond=found.q50 is None,
                extrapolated=any(exceeded[r.return_period_years].extrapolated for r in zone.rules),
            )
        )
        start = end
    return Rows(zones)


def _farthest(rule: Rule, x: Floats, exceeded: Exceeded) -> Floats:
    """The farthest x `[n_parameters]` where the rule holds, x[0] where it never does.

    Pressure is straight between places, and falls to nought at the runout itself.
    """
    runout, pressure = exceeded.runout_x, exceeded.pressure_kpa
    least = rule.pressure_kpa_min
    if least == 0.0:
        return np.asarray(np.maximum(runout, x[0]))
    holds = pressure >= least
    last = len(x) - 1 - np.argmax(holds[:, ::-1], axis=1)
    never = ~holds.any(axis=1)
    draw = np.arange(len(last))
    after = np.minimum(last + 1, len(x) - 1)
    above, below = pressure[draw, last], pressure[draw, after]
    after_x = np.where(below == 0.0, np.minimum(x[after], runout), x[after])
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.clip((above - least) / (above - below), 0.0, 1.0)
    between = x[last] + part * np.maximum(after_x - x[last], 0.0)
    return np.where(never, x[0], np.where(last == len(x) - 1, np.inf, between))


N_PLACES = 81
HELD_WORTH_A_NOTE = 0.05
"""Share of avalanches that stop at their release from which it is said."""


def path_zones(
    path: PathHazard,
    limits: ZoneSystem,
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
        interval=Note("interval_zones"),
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


def _notes(path_id: str, held: float, extrapolated: Sequence[float]) -> tuple[Note, ...]:
    notes = []
    if extrapolated:
        far = ", ".join(f"{period:g}" for period in extrapolated)
        notes.append(Note("periods_extrapolated", path_id, periods=far))
    if held > HELD_WORTH_A_NOTE:
        notes.append(Note("held_at_release", path_id, share=held, hint=Note("check_release")))
    return tuple(notes)
