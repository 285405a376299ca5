"""What the intervals of the 100-year runout hold; writes the tables of docs/coverage.md.

make coverage [ARGS=…]         200 datasets, and 60 of each harder kind; goes on from earlier runs
--plain 20 --harder 6          fewer; --sparse 50 of those with few records a path
--minutes 10 --workers 2       begin none after ten minutes; two at a time
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.hazard.exceedance import Avalanches, exceeded_runout
from avahazard.hazard.frequency import known_volumes, return_volume, volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.rows import spread, volume_stops
from avahazard.hazard.volume_source import VolumeSource
from avahazard.inference.likelihood.assemble import with_effects
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.inference.sampling import calibrate_model
from avahazard.inference.seeds import generator
from benchmarks.study import DOCS, HERE, Line, run_missing, table, write_parts
from benchmarks.true_worlds import (
    ARMS,
    AS_OF,
    DENSER,
    PLAIN,
    SPARSE,
    TrueWorld,
    exceeded_once,
    run_path,
    true_runouts,
    true_volumes,
)

YEARS = 100.0
PERIODS = (10.0, 30.0, 100.0, 300.0)
FAMILIES = {"gev": "GEV of yearly maxima", "gpd": "Pareto over the median"}
WAYS = {"b": "design runout", "a": "runout of the volume"}
CHAINS, DRAWS = 2, 400
FIRST_HARDER = 401
RECORDS = {"under 25": (0, 25), "25 to 39": (25, 40), "40 and more": (40, 1000)}
ARM_WORDS = {
    PLAIN: "as above",
    "paths differ": "paths differ (sd 0.12 on log friction); the model has the path effect",
    "limit of sight": "three in ten stop above the detection limit, which is given",
    SPARSE: "12 paths of about 5 records; no path has observed_from or observed_to",
    DENSER: "earlier avalanches were recorded more rarely; hazard with the mean rate",
    AS_OF: "the same datasets; hazard with --as-of the last year",
    "a third left": "a third of the records lie beyond the profile; hazard on the whole one",
}


def main() -> None:
    """Judge the datasets that have no result yet; write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plain", type=int, default=200)
    parser.add_argument("--harder", type=int, default=60)
    parser.add_argument("--sparse", type=int, default=200)
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--results", type=Path, default=HERE / "coverage.jsonl")
    parser.add_argument("--page", type=Path, default=DOCS / "coverage.md")
    given = parser.parse_args()
    plans = [
        (f"{arm} #{seed}", (arm, seed))
        for arm, seed in planned(given.plain, given.harder, given.sparse)
    ]
    found = run_missing(
        given.results, plans, judge_plan, minutes=given.minutes, workers=given.workers
    )
    write_parts(given.page, tables(found))


def planned(n_plain: int, n_harder: int, n_sparse: int) -> list[tuple[str, int]]:
    """Every arm with its datasets by seed."""
    harder = range(FIRST_HARDER, FIRST_HARDER + n_harder)
    return [
        *((PLAIN, seed) for seed in range(1, n_plain + 1)),
        *((arm, seed) for seed in harder for arm in ARMS if arm not in (PLAIN, SPARSE)),
        *((SPARSE, seed) for seed in range(1, n_sparse + 1)),
    ]


def judge_plan(plan: tuple[str, int]) -> Line:
    """A dataset of the plan, judged; the harder ones by the first family alone."""
    arm, seed = plan
    families = list(FAMILIES) if arm == PLAIN else list(FAMILIES)[:1]
    return {"arm": arm, **judge(ARMS[arm](seed), families)}


def judge(world: TrueWorld, families: Sequence[str] = tuple(FAMILIES)) -> Line:
    """The true runout of 100 years of each path, and the intervals of both ways.

    `rising`: whether no quantile of the design runout falls as T rises.
    """
    observations = build_observations(world.records if world.told is None else world.told)
    specification, facts = with_effects(observations, Specification(), world.effects)
    found = calibrate_model(
        observations, specification, facts, n_chains=CHAINS, n_draws=DRAWS, seed=world.seed
    )
    paths: list[Line] = []
    for k, site in enumerate(world.sites):
        path_id, runs = site.path.path_id, run_path(world, k)
        share = -np.log1p(-1.0 / YEARS) / world.rates[k]
        volume = float(true_volumes(world, k, np.array([1.0 - share]))[0])
        of_volume = true_runouts(world, k, runs, np.full(100_000, volume))
        line: Line = {
            "n_events": site.n_events,
            "true_volume_m3": volume,
            "true_x_m": _or_none(exceeded_once(world, k, true_runouts(world, k, runs), YEARS)),
            "true_of_volume_x_m": [
                _or_none(x) for x in np.quantile(of_volume, [0.05, 0.5, 0.95], method="lower")
            ],
        }
        for family in families:
            known, source = (
                known_volumes(world.records),
                VolumeSource(family=family, as_of=world.as_of),
            )
            frequency = volume_frequencies(known, world.seed, source).of(path_id)
            returned = return_volume(frequency, YEARS)
            volumes, at = frequency.volumes(), returned.volume_m3
            # On the whole profile, which the calibration may not have had.
            path = path_hazard(found, world.records, path_id, volumes, [at], seed=world.seed)
            b, rising = design(path.avalanches)
            a = spread(
                volume_stops(path, at, 20_000, generator(world.seed, "coverage", path_id))[0]
            )
            line[family] = {
                "volume_m3": [returned.q05_m3, at, returned.q95_m3],
                "a": [a.q05, a.q50, a.q95],
                "b": b,
                "rising": rising,
            }
        paths.append(line)
    converged = found.chains.diagnostics.converged
    return {"seed": world.seed, "converged": converged, "paths": paths}


def design(avalanches: Avalanches) -> tuple[list[float | None], bool]:
    """5, 50 and 95 % of the design runout of 100 years, and whether it rises with T."""
    by_period = {}
    for years in PERIODS:
        found = spread(exceeded_runout(avalanches, years))
        by_period[years] = [found.q05, found.q50, found.q95]
    quantiles = [[np.inf if q is None else q for q in row] for row in by_period.values()]
    with np.errstate(invalid="ignore"):  # from beyond the end to beyond the end
        rising = not np.any(np.diff(np.array(quantiles), axis=0) < 0.0)
    return by_period[YEARS], rising


def _or_none(x: float) -> float | None:
    return float(x) if np.isfinite(x) else None


def tables(lines: Sequence[Line]) -> dict[str, str]:
    """The tables of the page."""
    of_arm = {arm: [line for line in lines if line["arm"] == arm] for arm in ARMS}
    plain = kept(of_arm[PLAIN])
    intervals, harder, by_records, volumes, own = [], [], [], [], []
    for way, words in WAYS.items():
        for family, name in FAMILIES.items():
            found = [(interval(p, family, way), p["true_x_m"]) for w in plain for p in w]
            error = np.median([i[1] - truth for i, truth in found])
            width = np.median([i[2] - i[0] if np.isfinite(i[0]) else np.inf for i, _ in found])
            cells = _shares(plain, partial(_runout, family=family, way=way))
            intervals.append((words, name, *cells, f"{error:+.0f} m", f"{width:.0f} m"))
    for arm, selected in of_arm.items():
        if selected:
            paths = [p for world in kept(selected) for p in world]
            cells = _shares(kept(selected), partial(_runout, family="gev", way="b"))
            rising = f"{sum(p['gev']['rising'] for p in paths)} of {len(paths)}"
            harder.append((ARM_WORDS[arm], len(selected), len(paths), *cells, rising))
    for words, (low, high) in RECORDS.items():
        part = [[p for p in paths if low <= p["n_events"] < high] for paths in plain]
        if n := sum(map(len, part)):
            cells = [_shares(part, partial(_runout, family=f, way="b"))[0] for f in FAMILIES]
            by_records.append((words, n, *cells))
    for family, name in FAMILIES.items():
        off = [np.log(p[family]["volume_m3"][1] / p["true_volume_m3"]) for w in plain for p in w]
        cells = _shares(plain, partial(_volume, family=family))
        volumes.append((name, *cells, f"{np.median(off):+.2f}"))
        own.append((name, *(f"{np.median(_misses(plain, family, k)):+.0f} m" for k in range(3))))
    shares = ("covers", "below", "above")
    return {
        "intervals": f"{len(of_arm[PLAIN])} datasets.\n\n"
        + table(("answer", "frequency", *shares, "error", "width"), intervals),
        "harder": table(("datasets", "number", "paths", *shares, "rise with T"), harder),
        "by records": table(("records", "paths", *FAMILIES.values()), by_records),
        "volumes": table(("frequency", *shares, "error of log V"), volumes),
        "of the volume": table(("frequency", "5 %", "50 %", "95 %"), own),
    }


def kept(lines: Sequence[Line]) -> list[list[Line]]:
    """The paths of each dataset whose true runout lies on the profile."""
    return [[p for p in line["paths"] if p["true_x_m"] is not None] for line in lines]


def share(worlds: Sequence[Sequence[Line]], holds: Callable[[Line], bool]) -> tuple[float, float]:
    """Share of paths for which something holds, and its standard error over datasets."""
    hits = np.array([sum(holds(p) for p in paths) for paths in worlds], float)
    counts = np.array([len(paths) for paths in worlds], float)
    mean = float(hits.sum() / counts.sum())
    return mean, float(np.sum((hits - mean * counts) ** 2) ** 0.5 / counts.sum())


def covered(p: Line, family: str, way: str) -> bool:
    """Whether an interval holds the true runout."""
    return _runout(p, family, way) == 0


def interval(p: Line, family: str, way: str) -> list[float]:
    """5, 50 and 95 %; inf beyond the profile."""
    return [np.inf if v is None else float(v) for v in p[family][way]]


def _runout(p: Line, family: str, way: str) -> int:
    return _side(interval(p, family, way), p["true_x_m"])


def _volume(p: Line, family: str) -> int:
    return _side(p[family]["volume_m3"], p["true_volume_m3"])


def _side(found: Sequence[float], truth: float) -> int:
    """-1 where the truth lies below the interval, 1 where above, else 0."""
    return int(truth > found[2]) - int(truth < found[0])


def _shares(worlds: Sequence[Sequence[Line]], side: Callable[[Any], int]) -> tuple[str, str, str]:
    mean, error = share(worlds, lambda p: side(p) == 0)
    below, above = (share(worlds, lambda p, s=s: side(p) == s)[0] for s in (-1, 1))
    return f"{mean:.1%} ± {error:.1%}", f"{below:.1%}", f"{above:.1%}"


def _misses(worlds: Sequence[Sequence[Line]], family: str, k: int) -> list[float]:
    """A quantile of the runout of the volume less the true one, of each path."""
    paths = [p for w in worlds for p in w if p["true_of_volume_x_m"][k] is not None]
    return [interval(p, family, "a")[k] - p["true_of_volume_x_m"][k] for p in paths]


if __name__ == "__main__":
    main()
