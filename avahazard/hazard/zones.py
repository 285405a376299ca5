"""Speed and pressure along a path by return period, and zones by limits on them."""

import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from avahazard.arrays import Floats
from avahazard.effects.site import Site
from avahazard.hazard.exceedance import (
    QUANTILES,
    Avalanches,
    exceeded_runout,
    friction_shares,
    reach,
)
from avahazard.hazard.exceedance_kernel import share_under
from avahazard.hazard.extremes import annual_rate
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.rows import design_of, spread
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
from avahazard.notes import Note
from avahazard.physics.runout_curve import MU
from avahazard.records.errors import AvahazardError
from avahazard.records.toml_document import Strict, read_toml
from avahazard.results import hazard as results
from avahazard.results.base import Rows


class Rule(Strict):
    """Holds where `pressure_kpa_min` is exceeded once in `return_period_years` on average.

    With a least pressure of 0 it holds wherever an avalanche of that return period comes at all.
    """

    return_period_years: Annotated[float, Field(gt=1.0, allow_inf_nan=False)]
    pressure_kpa_min: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0


class ZoneLimits(Strict):
    """A zone: a place is in it where one of its `rules` holds and no worse zone's does."""

    name: Annotated[str, Field(min_length=1)]
    color: Annotated[str, Field(pattern="^#[0-9a-fA-F]{6}$"), AfterValidator(str.lower)]
    rules: Annotated[list[Rule], Field(min_length=1, alias="rule")]


class ZoneSystem(Strict):
    """Zones, the worst first; `notes` say what of the regulation the model cannot answer."""

    zones: Annotated[list[ZoneLimits], Field(min_length=1, alias="zone")]
    notes: list[str] = Field(default_factory=list)
    name: str = ""

    @property
    def return_periods(self) -> tuple[float, ...]:
        """The return periods (years) that the rules speak of, rising."""
        return tuple(sorted({r.return_period_years for z in self.zones for r in z.rules}))


_TEXT = (files("avahazard.hazard") / "zones.toml").read_text("utf-8")
PRESETS = {
    name: ZoneSystem.model_validate({"name": name, **limits})
    for name, limits in tomllib.loads(_TEXT).items()
}
EXAMPLE = (
    'A zone is written: [[zone]], name = "red", color = "#c8102e", and for each rule '
    "[[zone.rule]], return_period_years = 300, pressure_kpa_min = 30."
)


def read_limits(name: str, text: str) -> ZoneSystem:
    """Read the limits in `text`, a TOML document; `name` is that of its file.

    Zones stand in it from the worst to the least. Raises `AvahazardError`, which names the first
    place at fault, where it is no TOML, a value is missing, unknown or out of its range, or two
    zones have one name.
    """
    found = read_toml(name, text, ZoneSystem, EXAMPLE)
    names = [zone.name for zone in found.zones]
    for twice in names:
        if names.count(twice) > 1:
            raise AvahazardError(f"{name} has two zones '{twice}'.", "Give each its own name.")
    return found.model_copy(update={"name": name})


LEAST_RATE = 1e-30
STEEP = 0.05
"""Change of a share from one friction to the next that is straight enough between them."""
SPEED_HALVINGS = 16
"""Of squared speed: 0.1 m/s or less at the slowest that matter."""


def exceeded_speeds(avalanches: Avalanches, x: Floats, return_periods: Sequence[float]) -> Floats:
    """Speed (m/s) at places x (m) `[n_places]` that a year's fastest exceeds with chance 1/T.

    `[n_periods, n_parameters, n_places]`, T rising; 0 where avalanches come less often.

    With u(x; μ) the speed of the block, which falls as μ rises, the yearly rate of avalanches
    faster than s is Σ over classes of the rate of those with friction under the μ of u(x; μ) = s;
    the result is the s at which that rate is -log(1 - 1/T).
    """
    shares, kind = friction_shares(avalanches, (float(MU[0]), float(MU[-1])))
    wanted = np.array([annual_rate(period) for period in sorted(return_periods)])
    wanted = wanted[:, None] / np.maximum(avalanches.volumes.rate, LEAST_RATE)
    result = np.zeros((*wanted.shape, len(x)))
    of_classes = shares, kind, avalanches.class_share
    nu = np.log(MU) if avalanches.in_log else MU
    for g in range(len(avalanches.resistances)):
        selected = np.flatnonzero(avalanches.group == g)
        if len(selected):
            squares = _squares(avalanches, g, x)
            _exceeded_speeds(squares, *of_classes, selected, wanted, nu, result)
    return result


def _squares(avalanches: Avalanches, group: int, x: Floats) -> Floats:
    """Squared speeds `[n_classes, n_places, n_mu]` of the block as the front passes x."""
    site, classes = avalanches.site, zip(avalanches.release, avalanches.ahead[group], strict=True)
    cells = site.cells(avalanches.resistances[group])

    @cache
    def squares(release: int, ahead: float) -> Floats:
        release_x = float(site.release_x[release])
        return site.speeds(cells, release_x, _behind(site, x, ahead)).T ** 2

    found = np.array([squares(int(release), float(ahead)) for release, ahead in classes])
    # Rounding may lift a speed by an ulp over that of a lower friction.
    return np.ascontiguousarray(np.minimum.accumulate(found, axis=2))


def _behind(site: Site, x: Floats, distance: float) -> Floats:
    """x of the places `distance` metres along the path before x; above the top it goes on."""
    if distance == 0.0:
        return x
    terrain = site.terrain
    s = np.interp(x, terrain.x, terrain.s) - distance
    return np.asarray(np.interp(s, terrain.s, terrain.x) + np.minimum(s, 0.0))


@kernel
def _exceeded_speeds(squares, shares, kind, class_share, draws, wanted, nu, result):  # type: ignore[no-untyped-def]
    """Fill in the speeds of some `draws` that the shares `wanted` `[n_periods, …]` exceed.

    `nu` `[n_mu]` are the frictions of `squares`, or their logs, as `shares` take them.
    """
    under = np.empty((shares.low.shape[1], len(nu)))
    for p in draws:
        for k in range(len(under)):
            for j in range(len(nu)):
                under[k, j] = share_under(shares, p, k, nu[j])
        for i in range(squares.shape[1]):
            fastest = 0.0
            for j in range(len(squares)):
                fastest = max(fastest, squares[j, i, 0])
            bottom = 0.0
            for t in range(len(wanted)):
                # Longer periods, higher speeds: each starts from the one before.
                top = fastest
                moving = _share_over(squares, i, 0.0, under, shares, kind, class_share, p, nu)
                if moving < wanted[t, p]:
                    continue
                for _ in range(SPEED_HALVINGS):
                    middle = 0.5 * (bottom + top)
                    share = _share_over(squares, i, middle, under, shares, kind, class_share, p, nu)
                    if share >= wanted[t, p]:
                        bottom = middle
                    else:
                        top = middle
                result[t, p, i] = np.sqrt(0.5 * (bottom + top))


@kernel(inner=True, forceinline=True)
def _share_over(squares, i, square, under, shares, kind, class_share, p, nu):  # type: ignore[no-untyped-def]
    """Share of the avalanches of draw p whose squared speed at place i is over `square`.

    `under` `[n_kinds, n_mu]` are its shares with friction under each of `nu`.
    """
    total = 0.0
    for c in range(len(kind)):
        falling, k = squares[c, i], kind[c]
        # The first friction of the grid that does not exceed the level.
        first, end = 0, len(falling)
        while first < end:
            middle = (first + end) // 2
            if falling[middle] > square:
                first = middle + 1
            else:
                end = middle
        if first == 0:
            continue
        if first == len(falling):
            total += class_share[c] * under[k, first - 1]
            continue
        above, below = falling[first - 1], falling[first]
        if below == 0.0 and first > 1:
            # The block stops on the way to that friction: carried on from the cell before.
            below = min(2.0 * above - falling[first - 2], 0.0)
        part = (above - square) / (above - below)
        share = under[k, first - 1] + part * (under[k, first] - under[k, first - 1])
        if under[k, first] - under[k, first - 1] > STEEP:
            share = share_under(shares, p, k, nu[first - 1] + part * (nu[first] - nu[first - 1]))
        total += class_share[c] * share
    return total


def draw_densities(mean: float, sd: float, n: int, rng: np.random.Generator) -> Floats:
    """Flow densities `[n]` in kg/m3: lognormal with this mean and standard deviation."""
    variance = np.log1p((sd / mean) ** 2)
    noise = rng.standard_normal(n)
    return np.asarray(np.exp(np.log(mean) - 0.5 * variance + np.sqrt(variance) * noise))


@dataclass(frozen=True, slots=True, eq=False)
class Exceeded:
    """What is exceeded once in one return period, by posterior draw.

    `runout_x` (m) `[n_parameters]`, inf past the end of the profile; `pressure_kpa` `[n_parameters,
    n_places]`, 0 past the runout. `extrapolated`: the record is too short for the return period.
    """

    runout_x: Floats
    pressure_kpa: Floats
    extrapolated: bool = False


def zone_pieces(
    limits: ZoneSystem, x: Floats, exceeded: Mapping[float, Exceeded]
) -> Rows[results.Zone]:
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
            results.Zone(
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
    """The farthest x `[n_parameters]` where the rule holds; pressure is straight between places."""
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
    density: results.Density,
    extrapolated: Collection[float],
    seed: int,
) -> results.ZonedPath:
    """Speeds, pressures, chances and zones of one path.

    `periods` (years) rise and hold those of the limits; `density` is that of the flow;
    `extrapolated` are the periods that the record is too short for.
    """
    avalanches = path.avalanches
    rng = generator(seed, "density", path.path_id)
    densities = draw_densities(density.mean, density.sd, avalanches.n_parameters, rng)
    x, chance = reach(avalanches, N_PLACES)
    elevation = avalanches.site.smooth.height(x)
    speeds = exceeded_speeds(avalanches, x, periods)
    pressures = densities[:, None] * speeds**2 / 1000.0  # kPa
    exceeded = {
        period: Exceeded(exceeded_runout(avalanches, period), pressures[k], period in extrapolated)
        for k, period in enumerate(periods)
    }
    # [n_periods, 3, n_places]
    speed = np.quantile(speeds, QUANTILES, axis=1).swapaxes(0, 1)
    pressure = np.quantile(pressures, QUANTILES, axis=1).swapaxes(0, 1)
    # By the first place below the release.
    started = -np.log1p(-chance[1, 1])
    held = float(np.clip(1.0 - started / np.median(avalanches.volumes.rate), 0.0, 1.0))
    return results.ZonedPath(
        path_id=path.path_id,
        limits=limits.name,
        density_kg_m3=density,
        release_x_m=float(x[0]),
        end_x_m=float(x[-1]),
        interval=Note("interval_zones"),
        designs=Rows(
            results.PeriodDesign(period, found.extrapolated, design_of(path, found.runout_x))
            for period, found in exceeded.items()
        ),
        places=Rows(
            results.Place(
                x_m=float(x[i]),
                elevation_m=float(elevation[i]),
                p_reach_per_year=float(chance[1, i]),
                by_return_period=Rows(
                    results.ExceededHere(
                        return_period_years=period,
                        extrapolated=period in extrapolated,
                        speed_m_s=results.Quantiles(*speed[k, :, i].tolist()),
                        pressure_kpa=results.Quantiles(*pressure[k, :, i].tolist()),
                    )
                    for k, period in enumerate(periods)
                ),
            )
            for i in range(len(x))
        ),
        p_not_released=held,
        zones=zone_pieces(limits, x, exceeded),
        notes=_notes(path.path_id, held, [p for p in periods if p in extrapolated]),
    )


def _notes(path_id: str, held: float, extrapolated: Sequence[float]) -> tuple[Note, ...]:
    notes = []
    if extrapolated:
        far = ", ".join(f"{period:g}" for period in extrapolated)
        notes.append(Note("periods_extrapolated", path_id, periods=far))
    if held > HELD_WORTH_A_NOTE:
        notes.append(Note("held_at_release", path_id, share=held, hint=Note("check_release")))
    return tuple(notes)
