"""The rows of `hazard` of one path: design runout, runout of a volume, and what varies in each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import poisson

from avahazard.arrays import Floats, Ints
from avahazard.hazard.exceedance import (
    QUANTILES,
    SAMPLED_PLACES,
    Avalanches,
    at_volume,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    rates_past,
    reach,
)
from avahazard.hazard.extremes import ANY_VOLUME_M3
from avahazard.hazard.frequency import VolumeFrequency
from avahazard.hazard.path_hazard import WORTH_A_NOTE, PathHazard
from avahazard.inference.model.friction_model import FrictionKinds, shifted, widening
from avahazard.inference.seeds import generator
from avahazard.kernels import kernel
from avahazard.notes import Note
from avahazard.physics.block import NOT_RELEASED
from avahazard.physics.runout_curve import RunoutCurve, piece_at, pieces
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.hazard import (
    Design,
    HazardRow,
    ModelRunout,
    PlaceQuantiles,
    ReachChance,
    ReturnLevel,
    RunoutInterval,
    Spread,
    VolumeInterval,
    YearlyChances,
)

Pieces = tuple[Floats, NDArray[np.int8]]
"""`pieces` of curves `[n_curves, …]`."""

STEPS = tuple(k / 20 for k in range(1, 20))
"""Probabilities 5, 10, … 95 %, at which the distribution of the runout is reported."""


@kernel
def draw_stops(rng, rows, status, of, location, sd, in_log):  # type: ignore[no-untyped-def]
    """Draw a friction for each of the draws and run it down the path (Ancey 2005, § 3).

    `location`, `sd` `[n_draws]` are of log μ (`in_log`) or μ at the volume in question, by draws of
    the posterior, so that the spread holds the natural variability and the uncertainty of the
    parameters; `of` `[n_draws]` is the curve of each among the `Pieces`.

    Returns stops x and elevation (m) of the draws with μ > 0 `[n_positive]`, (+inf, -inf) where a
    run went beyond the profile, and their number by status `[3]`.
    """
    x, y, counts = np.empty(len(of)), np.empty(len(of)), np.zeros(3, np.int64)
    n = 0
    for i in range(len(of)):
        mu = location[i] + sd[i] * rng.standard_normal()
        if in_log:
            mu = np.exp(mu)
        if mu > 0.0:
            k, t = piece_at(rows[of[i]], mu)
            x[n] = rows[of[i], k, 0] + rows[of[i], k, 1] * t
            y[n] = rows[of[i], k, 2] + rows[of[i], k, 3] * t
            counts[status[of[i], k]] += 1
            n += 1
    return x[:n], y[:n], counts


UNKNOWN = Spread(None, None, None, None)


def spread(values: Floats) -> Spread:
    """Summary of stops `[n]`, infinite where the profile was left."""
    if not len(values):
        return UNKNOWN
    found = _known(order_statistics(values, QUANTILES))
    mean = None if None in found else float(values[np.isfinite(values)].mean())
    return Spread(mean, *found)


def _known(values: Floats) -> list[float | None]:
    """Values, None where they are infinite."""
    return [float(v) if np.isfinite(v) else None for v in values]


def order_statistics(values: Floats, probabilities: Sequence[float]) -> Floats:
    """Quantiles of stops `[n]` that are stops: np.quantile mixes neighbours, inf among them."""
    # Sorting all takes a sixth of `np.partition`: it runs in vectors.
    return np.asarray(np.sort(values)[[ceil(q * len(values)) - 1 for q in probabilities]])


def scattered_stops(
    smooth: SmoothProfile,
    release_x: float,
    elevation: Floats,
    sigma: Floats,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, int]:
    """Stops x and elevation (m) at `elevation` + `sigma` z, z ~ N(0, 1), and the number held.

    `elevation` `[n_draws]` of the block's stop is -inf beyond the profile, and stays so;
    `sigma` `[n_draws]` in m. x is the first place of the path that is so low. A stop above the
    release is put there and counted as held; one below the end of the path has left it (+inf,
    -inf); one below a valley floor with a counter-slope behind it lies on the floor.
    """
    x = np.linspace(release_x, smooth.x_max, SAMPLED_PLACES)
    y = smooth.height(x)
    # The places that are lower than all before them.
    falls = np.concatenate([[True], y[1:] < np.minimum.accumulate(y)[:-1]])
    stop = elevation + sigma * rng.standard_normal(len(elevation))
    held = stop > y[0]
    stop = np.where(held, y[0], stop)
    if not falls[-1]:
        stop = np.where(np.isfinite(elevation), np.maximum(stop, y.min()), stop)
    left = stop < y.min()
    place = np.interp(-stop, -y[falls], x[falls])
    return np.where(left, np.inf, place), np.where(left, -np.inf, stop), int(np.sum(held))


def row_notes(path: PathHazard, row: HazardRow) -> tuple[Note, ...]:
    """The notes on one row, without the name of its path."""
    notes = []
    if row.p_not_released > WORTH_A_NOTE:
        notes.append(Note("not_started", share=row.p_not_released, hint=Note("check_release")))
    period, found = row.return_period_years, row.design
    if period is not None and not path.rate_known:
        notes.append(Note("no_rate"))
    if found is not None and found.p_beyond > WORTH_A_NOTE:
        wholly = found.p_beyond > 1.0 - WORTH_A_NOTE
        notes.append(Note("all_beyond" if wholly else "part_beyond", period=period))
    if found is not None and path.avalanches.sigma_m is not None:
        x = found.runout_x_m
        if x.q95 is not None and x.q50 == x.q95:
            notes.append(Note("on_floor", period=period))
    if (past := _many_beyond(row)) is not None:
        notes.append(past)
    if row.extrapolated:
        notes.append(Note("extrapolated", period=period))
    if row.n_nonpositive_friction:
        notes.append(Note("not_positive"))
    if path.rising is not None:
        notes.append(path.rising)
    return tuple(notes)


def row_interval(path: PathHazard, return_period: bool) -> Note:
    """What varies within the 5 to 95 % of a row."""
    parts = [*natural_parts(path), *_parameter_parts(path)]
    if not path.varying.volume:
        return Note("interval_any", parts=parts)
    return Note("interval_period" if return_period else "interval_volume", parts=parts)


def parameters_interval(path: PathHazard, *, return_period: bool) -> Note:
    """What varies in `parameters`."""
    parts = _parameter_parts(path)
    if return_period and path.varying.volume:
        parts.append(Note("of_volume_error"))
    return Note("interval_parameters", parts=parts)


def design_interval(path: PathHazard) -> Note:
    """What varies in `design`, and what is mixed."""
    mixed = natural_parts(path)
    parts = [*_parameter_parts(path), Note("of_rate_error")]
    if path.varying.volume:
        mixed.insert(0, Note("of_all_volumes"))
        parts.append(Note("of_frequency_error"))
    return Note("interval_design", parts=parts, mixed=mixed)


def natural_parts(path: PathHazard) -> list[Note]:
    """The natural variability, the volume apart."""
    in_log = path.avalanches.in_log
    if path.avalanches.sigma_m is not None:
        family = "of_elevation"
    elif path.avalanches.student:
        family = "of_lognormal_student" if in_log else "of_normal_student"
    else:
        family = "of_lognormal" if in_log else "of_normal"
    more = {"of_release": path.varying.release, "of_columns": path.varying.columns}
    return [Note(family), *(Note(key) for key, varies in more.items() if varies)]


def _parameter_parts(path: PathHazard) -> list[Note]:
    return [Note("of_parameters"), *([Note("of_unknown_path")] if path.offset_unknown else [])]


@dataclass(frozen=True, slots=True)
class Weighted:
    """A path by one of several models, and the weight of that model."""

    model: str
    weight: float
    path: PathHazard


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


def volume_stops(
    path: PathHazard, volume_m3: float, n_draws: int, rng: np.random.Generator
) -> tuple[Floats, Floats, int]:
    """Stops of avalanches of one of the volumes of `path`, from `n_draws` over the posterior.

    Every draw takes one of the classes of future avalanches. Returns x and elevation (m) as
    `draw_stops`, and how many were not released.
    """
    draws, avalanches, here = path.draws, path.avalanches, path.at_volume[volume_m3]
    parameter = np.arange(n_draws) * len(draws.u) // n_draws
    event = rng.integers(avalanches.n_classes, size=n_draws)
    shift = draws.shift(rng)[parameter]
    if draws.kinds is not None:
        kinds = FrictionKinds(*(part[parameter] for part in draws.kinds))
        shift = shift + kinds.drawn(rng.uniform(size=n_draws))
    location = shifted(here.location[parameter, event], shift, avalanches.in_log)
    scatter = here.scatter[parameter, event]
    if avalanches.student:
        scatter = scatter * widening(rng, n_draws)
    if draws.sigma_m is not None:
        scatter = np.zeros(n_draws)
    curves, kind = _curves(here.curves)
    of = kind[draws.group[parameter], event]
    # Draws by one curve together: its pieces are then in the cache.
    order = np.argsort(of.astype(np.uint16), kind="stable")
    given = of[order], location[order], scatter[order], avalanches.in_log
    x, y, counts = draw_stops(rng, *curves, *given)
    held = int(counts[NOT_RELEASED])
    if draws.sigma_m is not None:
        site = avalanches.site
        release_x = float(site.release_x[avalanches.release[0]])
        sigma = draws.sigma_m[parameter[order]]
        x, y, held = scattered_stops(site.smooth, release_x, y, sigma, rng)
    return x, y, held


@lru_cache(maxsize=4)
def _curves(curves: tuple[RunoutCurve, ...]) -> tuple[Pieces, Ints]:
    """The curves of all groups, each once, and which of them each class has.

    The latter is `[n_groups, n_classes]`. Of the last they are kept, as by `exceedance.stops`.
    """
    x = curves[len(curves) // 2].x
    _, first, kind = np.unique(x, axis=0, return_index=True, return_inverse=True)
    parts = [pieces(curve[first]) for curve in curves]
    straight, status = (np.concatenate(part) for part in zip(*parts, strict=True))
    return (straight, status), np.add.outer(np.arange(len(curves)) * len(first), kind.ravel())


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
    of_nature = Note("interval_nature", parts=natural_parts(path))
    natural = runout_interval(avalanches, natural_runouts(fixed), of_nature)
    return natural, runout_interval(avalanches, middle_runout(uncertain), of_parameters)


def runout_interval(avalanches: Avalanches, x: Floats, interval: Note) -> RunoutInterval:
    """Mean and quantiles of runouts x (m) `[n]`, inf beyond the profile; what varies."""
    return RunoutInterval(spread(x), spread(_heights(avalanches.site.smooth, x)), interval)


def annual_reach(models: Sequence[Weighted]) -> ReachChance:
    """The annual chance of reaching places on the path."""
    first = models[0].path.avalanches
    x, chance = reach(
        first,
        rates=lambda x: by_weight(models, [rates_past(one.path.avalanches, x) for one in models]),
    )
    height = first.site.smooth.height(x)
    chances = YearlyChances(*map(tuple, chance.tolist()))
    return ReachChance(tuple(x.tolist()), tuple(height.tolist()), chances)


def design_of(path: PathHazard, x: Floats) -> Design:
    """What is said of the runouts x (m) `[n_parameters]` of a return period, inf past the end.

    Every return period takes the same draws of the parameters, and in each draw the runout rises
    with it (`exceeded_runout`): so do all quantiles, whatever friction does with volume.
    """
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
    return PlaceQuantiles(*_known(order_statistics(x, QUANTILES)))


def elevation_quantiles(smooth: SmoothProfile, x: Floats) -> PlaceQuantiles:
    """5, 50 and 95 % of the elevations at places x (m) `[n]`, inf below all others.

    By depth, so that on falling ground each is the elevation at the mirrored quantile of x.
    """
    shallow, middle, deep = _known(-order_statistics(-_heights(smooth, x), QUANTILES))
    return PlaceQuantiles(q05=deep, q50=middle, q95=shallow)


def _heights(smooth: SmoothProfile, x: Floats) -> Floats:
    """Elevations (m) at places x (m) `[n]`, -inf beyond the profile."""
    inside = np.isfinite(x)
    return np.where(inside, smooth.height(np.where(inside, x, smooth.x_max)), -np.inf)


def hazard_row(
    scenario: Scenario, x: Floats, y: Floats, n_not_released: int, n_draws: int, interval: Note
) -> HazardRow:
    """The row of a scenario, of stops `[n_positive]` and their number held as by `volume_stops`.

    `interval` says what varies between the draws. Draws with μ ≤ 0, which the normal distribution
    allows and no block can have, are counted and in none of the other numbers; shares are of the
    rest. Runs beyond the profile are beyond every stop. Where the volume of a return period
    comes from is left out for a volume that the user gave.
    """
    n, told = len(x), dict[str, Any]()
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
                "years_not_observed": len(record.gaps),
                "years_from": record.window,
                "events_per_year": record.events_per_year,
            }
    return HazardRow(
        path_id=scenario.path_id,
        return_period_years=scenario.return_period,
        volume_m3=scenario.volume_m3,
        runout_x_m=spread(x),
        runout_elevation_m=spread(y),
        runout_x_steps_m=tuple(_known(order_statistics(x, STEPS))) if n else (),
        interval=interval,
        p_left_profile=np.count_nonzero(np.isinf(x)) / max(n, 1),
        p_not_released=n_not_released / max(n, 1),
        n_draws=n_draws,
        n_nonpositive_friction=n_draws - n,
        **told,
    )


HELD_TOO_MANY = 0.5
"""Share of draws that do not start from which no bounds are given."""


TOO_MANY = 0.01
"""Chance of as many records past a design runout below which that is worth a note."""


def _many_beyond(row: HazardRow) -> Note | None:
    """That more records lie past the median than its return period lets expect, if so."""
    period, found = row.return_period_years, row.design
    first, last = row.first_year, row.last_year
    if period is None or found is None or not found.records_beyond or first is None or last is None:
        return None
    years = last - first + 1 - (row.years_not_observed or 0)
    n, expected = found.records_beyond, years / period
    if poisson.sf(n - 1, expected) > TOO_MANY:
        return None
    told = {"n": n, "total": found.n_records, "expected": expected, "years": years}
    return Note("many_beyond", period=period, **told)


def path_rows(
    models: Sequence[Weighted], scenarios: Sequence[Scenario], n_draws: int, seed: int
) -> list[HazardRow]:
    """A row for each scenario of a path (`workflow.hazard`), each from `n_draws` draws.

    By one model, or by several, each with its weight among the draws: intervals then hold too that
    it is not known which is right, and natural variability and uncertainty of parameters are not
    distinguished. The first row has `reach`, the annual chance along the path, where the rate is
    known. A row hangs on the seed, its path and its scenario, not on the other rows.
    """
    rows = [_row(models, scenario, n_draws, seed) for scenario in scenarios]
    if models[0].path.rate_known:
        rows[0] = replace(rows[0], reach=annual_reach(models))
    return rows


def parts(models: Sequence[Weighted], n: int) -> list[int]:
    """How many of `n` draws each model has."""
    ends = np.round(np.cumsum([0.0, *(one.weight for one in models)]) * n)
    return [int(k) for k in np.diff(ends)]


REPEATED = 10
"""Times that draws of several models are taken, about, so that all of them stand by weight."""


def by_weight(models: Sequence[Weighted], values: Sequence[Floats]) -> Floats:
    """Values `[n_models][…, n_draws]` of all models together, each by its weight."""
    if len(models) == 1:
        return values[0]
    n = REPEATED * max(each.shape[-1] for each in values)
    counts = zip(values, parts(models, n), strict=True)
    taken = [each[..., np.arange(k) * each.shape[-1] // max(k, 1)] for each, k in counts]
    return np.concatenate(taken, axis=-1)


def _row(models: Sequence[Weighted], scenario: Scenario, n_draws: int, seed: int) -> HazardRow:
    path, period = models[0].path, scenario.return_period
    keys = (seed, "hazard", path.path_id, repr(scenario.volume_m3), repr(period))
    drawn = [
        volume_stops(one.path, scenario.any_volume_m3, n, generator(*keys))
        for one, n in zip(models, parts(models, n_draws), strict=True)
    ]
    x = [stops[0] for stops in drawn]
    y = np.concatenate([stops[1] for stops in drawn])
    n_held, interval = sum(stops[2] for stops in drawn), row_interval(path, period is not None)
    row = hazard_row(scenario, np.concatenate(x), y, n_held, n_draws, interval)
    if row.p_not_released > HELD_TOO_MANY:
        row = replace(row, runout_x_m=UNKNOWN, runout_elevation_m=UNKNOWN)
    else:
        if period is not None and path.rate_known:
            x = [exceeded_runout(one.path.avalanches, period) for one in models]
            row = replace(row, design=design_of(path, by_weight(models, x)))
        if len(models) == 1:
            natural, parameters = uncertainties(path, scenario)
            row = replace(row, natural=natural, parameters=parameters)
        else:
            told = zip(models, x, strict=True)
            of = (ModelRunout(m.model, m.weight, place_quantiles(v)) for m, v in told if len(v))
            row = replace(row, by_model=tuple(of), interval=_of_model(row.interval))
            if row.design is not None:
                design = replace(row.design, interval=_of_model(row.design.interval))
                row = replace(row, design=design)
    return replace(row, notes=row_notes(path, row))


def _of_model(interval: Note) -> Note:
    """The interval of an average: it holds too that it is not known which model is right."""
    parts = [*interval.values["parts"], Note("of_model")]
    return Note(interval.key, **{**interval.values, "parts": parts})
