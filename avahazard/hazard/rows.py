"""The rows of `hazard` of one path: design runout, runout of a volume, and what varies in each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.hazard.avalanches import ANY_VOLUME_M3
from avahazard.hazard.exceedance import (
    at_volume,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    reach,
    runout_interval,
)
from avahazard.hazard.frequency import VolumeFrequency
from avahazard.hazard.notes import (
    design_interval,
    natural_interval,
    parameters_interval,
    row_interval,
    row_notes,
)
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import (
    QUANTILES,
    Pieces,
    RunoutBounds,
    bounds_of_stops,
    draw_stops,
    order_statistics,
    scattered_stops,
)
from avahazard.inference.model.friction_scatter import shifted, widening
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_curve import MU, RunoutCurve, friction_grid, pieces
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.hazard import (
    Design,
    HazardRow,
    PlaceQuantiles,
    ReachChance,
    ReturnLevel,
    RunoutInterval,
    Spread,
    VolumeInterval,
    YearlyChances,
)


@dataclass(frozen=True, slots=True)
class Scenario:
    """A row of `hazard` to come.

    `volume_m3` is None where the model has no use for it and nothing is known of it;
    `return_period` (years) is None for a volume that the user gave, and `returned` and
    `frequency`, the volume of the period and where it comes from, where they are not known.
    """

    path_id: str
    volume_m3: float | None
    return_period: float | None = None
    returned: ReturnLevel | None = None
    frequency: VolumeFrequency | None = None

    @property
    def any_volume_m3(self) -> float:
        """The volume, or one that stands for it where it does not matter."""
        return ANY_VOLUME_M3 if self.volume_m3 is None else self.volume_m3


def volume_bounds(
    path: PathHazard, volume_m3: float, n_draws: int, rng: np.random.Generator
) -> RunoutBounds:
    """Bounds of the runout of one of the volumes of `path`, from `n_draws` over the posterior.

    Every draw takes one of the classes of avalanches to come.
    """
    draws, avalanches, here = path.draws, path.avalanches, path.at_volume[volume_m3]
    parameter = np.arange(n_draws) * len(draws.u) // n_draws
    event = rng.integers(avalanches.n_classes, size=n_draws)
    shift = draws.shift(rng)
    location = shifted(here.location[parameter, event], shift[parameter], avalanches.in_log)
    scatter = here.scatter[parameter, event]
    if avalanches.student:
        scatter = scatter * widening(rng, n_draws)
    if draws.sigma_m is not None:
        scatter = np.zeros(n_draws)
    curves, kind = _curves(here.curves)
    of = kind[draws.group[parameter], event]
    # Draws by one curve together: its pieces are then at hand.
    order = np.argsort(of.astype(np.uint16), kind="stable")
    x, y, counts = draw_stops(
        *(curves, of[order], location[order], scatter[order]),
        *(n_draws, rng),
        in_log=avalanches.in_log,
    )
    held = int(counts[NOT_RELEASED])
    if draws.sigma_m is not None:
        site = avalanches.site
        release_x = float(site.release_x[avalanches.release[0]])
        sigma = draws.sigma_m[parameter[order]]
        x, y, held = scattered_stops(site.smooth, release_x, y, sigma, rng)
    return bounds_of_stops(x, y, held, n_draws)


@lru_cache(maxsize=4)
def _curves(curves: tuple[RunoutCurve, ...]) -> tuple[Pieces, Ints]:
    """The curves of all groups, each once, and which of them each class has.

    The latter is `[n_groups, n_classes]`. Of the last they are kept, as by `exceedance.stops`.
    """
    rows = [tuple(row) for row in curves[len(curves) // 2].x.tolist()]
    different = sorted(set(rows))
    first = [rows.index(row) for row in different]
    kind = np.array([different.index(row) for row in rows])
    parts = [pieces(curve[first]) for curve in curves]
    straight, status = (np.concatenate(part) for part in zip(*parts, strict=True))
    each = straight, status, friction_grid(MU)
    return each, np.add.outer(np.arange(len(curves)) * len(first), kind)


def uncertainties(path: PathHazard, scenario: Scenario) -> tuple[RunoutInterval, RunoutInterval]:
    """Natural variability and uncertainty of the parameters, apart.

    The runout of avalanches of the scenario's volume, all parameters at their middle; and its
    median over the posterior of friction, and of the volume of the return period.
    """
    avalanches, period = path.avalanches, scenario.return_period
    volume = np.full(avalanches.n_parameters, np.log(scenario.any_volume_m3))
    fixed = uncertain = at_volume(avalanches, volume)
    if scenario.frequency is not None and period is not None:
        uncertain = at_volume(avalanches, scenario.frequency.draws.log_volume(1.0 / period))
    of_parameters = parameters_interval(path, return_period=period is not None)
    natural = runout_interval(avalanches, natural_runouts(fixed), natural_interval(path))
    return natural, runout_interval(avalanches, middle_runout(uncertain), of_parameters)


def annual_reach(path: PathHazard) -> ReachChance:
    """The annual chance of reaching places on the path."""
    found = reach(path.avalanches)
    low, middle, high = (tuple(chances) for chances in found.chance.T.tolist())
    return ReachChance(
        x_m=tuple(found.x.tolist()),
        elevation_m=tuple(found.elevation.tolist()),
        p_per_year=YearlyChances(low, middle, high),
    )


def design(path: PathHazard, return_period_years: float) -> Design | None:
    """The design runout of a return period over 1 year; None where the path's rate is not known.

    Every return period takes the same draws of the parameters, and in each draw the runout rises
    with it (`avalanches.exceeded`): so do all quantiles, whatever friction does with volume.
    """
    if not path.rate_known:
        return None
    return design_of(path, exceeded_runout(path.avalanches, return_period_years))


def design_of(path: PathHazard, x: Floats) -> Design:
    """The same of the runouts x (m) `[n_parameters]` of a return period, inf past the end."""
    places = place_quantiles(x)
    middle, recorded = places.q50, path.recorded
    return Design(
        runout_x_m=places,
        runout_elevation_m=elevation_quantiles(path.avalanches.site.smooth, x),
        p_beyond=float(np.mean(np.isinf(x))),
        point=None if middle is None else recorded.point(middle),
        farthest_record=recorded.farthest(),
        records_beyond=None if middle is None else recorded.beyond(middle),
        n_records=len(recorded.x),
        interval=design_interval(path),
    )


def place_quantiles(x: Floats) -> PlaceQuantiles:
    """5, 50 and 95 % of places x (m) `[n]`, inf beyond the profile; each is one of them."""
    found = order_statistics(x, QUANTILES)
    return PlaceQuantiles(*(float(q) if np.isfinite(q) else None for q in found))


def elevation_quantiles(smooth: SmoothProfile, x: Floats) -> PlaceQuantiles:
    """5, 50 and 95 % of the elevations at places x (m) `[n]`, inf below all others.

    By depth, so that on falling ground each is the elevation at the mirrored quantile of x.
    """
    inside = np.isfinite(x)
    depth = np.where(inside, -smooth.height(np.where(inside, x, smooth.x_max)), np.inf)
    shallow, middle, deep = (
        -float(q) if np.isfinite(q) else None for q in order_statistics(depth, QUANTILES)
    )
    return PlaceQuantiles(q05=deep, q50=middle, q95=shallow)


def hazard_row(scenario: Scenario, bounds: RunoutBounds, interval: Note) -> HazardRow:
    """The row of a scenario; `interval` says what varies between the draws.

    Where the volume of a return period comes from is left out for a volume that the user gave.
    """
    told: dict[str, Any] = {}
    returned, frequency = scenario.returned, scenario.frequency
    if returned is not None and frequency is not None:
        told = {
            "volume_interval_m3": VolumeInterval(returned.q05_m3, returned.q95_m3),
            "volume_method": frequency.method,
            "volume_source": frequency.source,
            "pooled": frequency.pooled,
            "extrapolated": returned.extrapolated,
        }
        if (record := frequency.record) is not None:
            told |= {
                "n_records": record.n_events,
                "first_year": record.first_year,
                "last_year": record.last_year,
                "years_not_observed": record.n_unobserved,
                "years_from": record.window,
                "events_per_year": record.events_per_year,
            }
    return HazardRow(
        path_id=scenario.path_id,
        return_period_years=scenario.return_period,
        volume_m3=scenario.volume_m3,
        runout_x_m=bounds.x,
        runout_elevation_m=bounds.elevation,
        runout_x_steps_m=bounds.x_steps,
        interval=interval,
        p_left_profile=bounds.p_left_profile,
        p_not_released=bounds.p_not_released,
        n_draws=bounds.n_draws,
        n_nonpositive_friction=bounds.n_nonpositive,
        **told,
    )


HELD_TOO_MANY = 0.5
"""Share of draws that do not start from which no bounds are given."""
UNKNOWN = Spread(None, None, None, None)


def path_rows(
    path: PathHazard, scenarios: Sequence[Scenario], n_draws: int, seed: int
) -> list[HazardRow]:
    """A row for each scenario of a path (`workflow.hazard`), each from `n_draws` draws.

    The first has `reach`, the annual chance along the path, where the rate is known. A row hangs
    on the seed, its path and its scenario, not on the other rows.
    """
    rows = [_row(path, scenario, n_draws, seed) for scenario in scenarios]
    if path.rate_known:
        rows[0] = replace(rows[0], reach=annual_reach(path))
    return rows


def _row(path: PathHazard, scenario: Scenario, n_draws: int, seed: int) -> HazardRow:
    period = scenario.return_period
    keys = (seed, "hazard", path.path_id, repr(scenario.volume_m3), repr(period))
    bounds = volume_bounds(path, scenario.any_volume_m3, n_draws, generator(*keys))
    held = bounds.p_not_released > HELD_TOO_MANY
    if held:
        bounds = replace(bounds, x=UNKNOWN, elevation=UNKNOWN)
    row = hazard_row(scenario, bounds, row_interval(path, return_period=period is not None))
    if not held:
        of_period = None if period is None else design(path, period)
        natural, parameters = uncertainties(path, scenario)
        row = replace(row, design=of_period, natural=natural, parameters=parameters)
    return replace(row, notes=row_notes(path, row))
