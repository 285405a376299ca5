"""Flow models on the terrain of paths: their runs, made, stored and resumed, and maps from them.

On paths that have runs a map gives in each cell the annual chance that an avalanche arrives, and
that its peak pressure exceeds some limits; on others the chance along the line, as wide as flow.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.engine import spread_map
from avahazard.engines.com1dfa import ENGINE, find_python, simulate
from avahazard.gis import require_packages
from avahazard.hazard.chance_map import annual_chance, friction_field
from avahazard.hazard.exceedance import Avalanches, reach
from avahazard.hazard.frequency import volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.hazard.zones import ZoneSystem
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.model.choices import BLOCK
from avahazard.notes import Note
from avahazard.records.collection import (
    Path,
    Records,
    Simulation,
    TerrainCrop,
    find_path,
    find_profile,
    ground_of,
)
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.terrain import (
    PERIOD_COLORS,
    ChanceMap,
    MappedBy,
    SimulatedPath,
    SimulationPlan,
    Simulations,
)
from avahazard.store.records import load_records, load_simulations, load_terrain, save_simulation
from avahazard.store.results import now
from avahazard.store.session import reading, writing
from avahazard.workers import n_workers
from avahazard.workflow.by_path import survey
from avahazard.workflow.export import drawn_path, replace_file
from avahazard.workflow.hazard import load_limits
from avahazard.workflow.requests import MapRequest, SimulateRequest
from avahazard.workflow.stored import load_stored, notes_of_fit, require_friction_scatter

if TYPE_CHECKING:
    from avahazard.gis.avaframe_project import Ground
    from avahazard.gis.hazard_map import MappedPath
    from avahazard.gis.map_files import MapGrid

LOWEST, HIGHEST, N_FRICTIONS, N_VOLUMES = 0.1, 0.6, 8, 4
FAR_APART_M, LEAST_STEP, ROUNDS = 50.0, 0.01, 3
"""Stops of neighbours in friction that are farther apart get a run between them, so often."""
DEFAULT_WIDTH_M = 100.0
SECONDS_A_CELL, BYTES_A_CELL = 1e-3, 0.5
"""Time of a run where none is stored, and its size in the database."""


@dataclass(frozen=True, slots=True, eq=False)
class RunPath:
    """A path made ready: its ground with a digest of it, and the volumes (m3) to run.

    Its release is `drawn` (corners `[n, 2]`), else made about `start_x` (m), `width_m` wide.
    """

    ground: Ground
    digest: str
    volumes: tuple[float, ...]
    start_x: float
    width_m: float
    drawn: Floats | None

    @property
    def path_id(self) -> str:
        """Its name."""
        return self.ground.crop.path_id

    def corners(self, volume_m3: float) -> Floats:
        """Corners `[n, 2]` of the release of a volume."""
        from avahazard.gis.avaframe_project import made_release  # noqa: PLC0415 (may be missing)

        if self.drawn is not None:
            return self.drawn
        return made_release(self.ground, self.start_x, self.width_m, volume_m3)


Task = tuple[int, float, float]
"""A run: the number of its path, its friction, its volume (m3)."""


def simulate_paths(database: str, request: SimulateRequest, report: Report = silent) -> Simulations:
    """Run a flow model on the paths named, or all with terrain, and store every run when it ends.

    What is stored already on the same ground is not run again. Raises `AvahazardError` where the
    engine is not there, a path is unknown or has no terrain, no volume is known, or a run fails.
    """
    python = find_python()
    paths, notes = ready_paths(database, request)
    shared = database, python, paths, request.drag
    made: list[Task] = []
    rounds = 1 if request.frictions else ROUNDS + 1
    for turn in range(rounds):
        tasks = _left(database, paths, request, refine=turn > 0)
        if not tasks:
            break
        words = f"Simulating, round {turn + 1}"
        # Each round to come is taken to have as many runs as this one.
        whole = len(made) + len(tasks) * (rounds - turn)
        report(words, len(made) / whole)
        for task in spread_map(_run, shared, tasks):
            made.append(task)
            report(words, len(made) / whole)
    report("Simulating", 1.0)
    n_new = Counter(path for path, _, _ in made)
    rows = Rows(_row(p.path_id, _of(database, p, request), n_new[k]) for k, p in enumerate(paths))
    return Simulations(rows, notes if made else (*notes, Note("simulated_before")))


def plan_simulations(database: str, request: SimulateRequest) -> SimulationPlan:
    """Estimate time and disk of `simulate_paths` with this request, before it refines.

    Raises `AvahazardError` as that does, except where the engine is missing.
    """
    paths, _ = ready_paths(database, request)
    n_left = len(_left(database, paths, request, refine=False))
    done = [one.seconds for path in paths for one in _of(database, path, request)]
    cells = np.mean([path.ground.crop.elevation_m.size for path in paths])
    seconds = float(np.mean(done) if done else SECONDS_A_CELL * cells)
    return SimulationPlan(
        n_runs=n_left + len(done),
        n_done=len(done),
        workers=n_workers(),
        seconds_per_run=seconds,
        measured=bool(done),
        seconds=seconds * n_left / n_workers(),
        stored_bytes=int(BYTES_A_CELL * cells * n_left),
    )


def ready_paths(database: str, request: SimulateRequest) -> tuple[list[RunPath], tuple[Note, ...]]:
    """The paths to run, and which have no terrain. Raises as `simulate_paths`."""
    require_packages()
    from avahazard.gis.avaframe_project import drawn_release, ground  # noqa: PLC0415

    with reading(database) as session:
        records = load_records(session)
        named = [find_path(records, name) for name in request.paths] or list(records.paths)
        crops = {path.path_id: load_terrain(session, path.path_id) for path in named}
    bare = [path.path_id for path in named if crops[path.path_id] is None]
    if len(bare) == len(named) or (bare and request.paths):
        raise AvahazardError(
            f"There is no terrain for {', '.join(bare) or 'any path: there are none'}.",
            "Import its line with a terrain model: avahazard import LINES --dem FILE.",
        )
    found = []
    for path in named:
        if (crop := crops[path.path_id]) is None:
            continue
        one = drawn_path(records, path)
        if isinstance(one, str):
            raise AvahazardError(
                f"Path {path.path_id} cannot be laid on its terrain: {one}.",
                "Import its line again with --dem and --update.",
            )
        there = ground(one.line, crop)
        drawn = None if request.release is None else drawn_release(request.release, there)
        volumes = tuple(request.volumes or volumes_of(records, path.path_id))
        digest = ground_of(path, find_profile(records, path), crop)
        width = one.width_m or DEFAULT_WIDTH_M
        found.append(RunPath(there, digest, volumes, one.release_x, width, drawn))
    notes = (Note("no_terrain", paths=", ".join(bare)),) if bare else ()
    return found, notes


def volumes_of(records: Records, path_id: str) -> list[float]:
    """Volumes (m3) to be run: evenly in their log from the smallest recorded to the largest.

    Those of the path, or of all paths where it has none. Raises `AvahazardError` for none at all.
    """
    known = [(e.path_id, e.volume_m3) for e in records.events if e.volume_m3]
    selected = [v for path, v in known if path == path_id] or [v for _, v in known]
    if not selected:
        raise AvahazardError("No volume is recorded.", "Name volumes: --volume 10000.")
    least, most = min(selected), max(selected)
    evenly = np.geomspace(least, most, N_VOLUMES if most > least else 1)
    return [float(f"{v:.3g}") for v in evenly]


def _left(
    database: str, paths: Sequence[RunPath], request: SimulateRequest, *, refine: bool
) -> list[Task]:
    """The runs that are not there yet: of the first table, or between neighbours far apart."""
    first = [round(float(mu), 4) for mu in np.linspace(LOWEST, HIGHEST, N_FRICTIONS)]
    tasks: list[Task] = []
    for k, path in enumerate(paths):
        of_volume: dict[float, dict[float, float]] = {volume: {} for volume in path.volumes}
        for one in _of(database, path, request):
            of_volume.get(one.volume_m3, {})[one.friction] = one.stop_x_m
        for volume, stops in of_volume.items():
            wanted = _between(stops) if refine else request.frictions or first
            tasks += [(k, mu, volume) for mu in wanted if mu not in stops]
    return tasks


def _between(stops: dict[float, float]) -> list[float]:
    """Frictions between neighbours whose stops (m) are far apart; what did not move stopped."""
    known = sorted(stops.items())
    return [
        round(0.5 * (low + high), 4)
        for (low, far), (high, near) in pairwise(known)
        if far - np.nan_to_num(near) > FAR_APART_M and high - low > 2.0 * LEAST_STEP
    ]


def _run(shared: tuple[str, FilePath, list[RunPath], float], task: Task) -> Task:
    (database, python, paths, drag), (k, friction, volume) = shared, task
    path = paths[k]
    found = simulate(python, path.ground, path.digest, path.corners(volume), friction, volume, drag)
    with writing(database) as session:
        save_simulation(session, found)
    return task


def _of(database: str, path: RunPath, request: SimulateRequest) -> list[Simulation]:
    """The stored runs of a path on its present ground."""
    with reading(database) as session:
        runs = load_simulations(session, lambda column: column == path.path_id)
    wanted = ENGINE, path.digest, request.drag
    return [one for one in runs if (one.engine, one.ground, one.drag_per_m) == wanted]


def _row(path_id: str, runs: Sequence[Simulation], n_new: int) -> SimulatedPath:
    stops = [one.stop_x_m for one in runs if np.isfinite(one.stop_x_m)]
    friction, volume = [s.friction for s in runs], [s.volume_m3 for s in runs]
    return SimulatedPath(
        path_id=path_id,
        engine=ENGINE,
        n_runs=len(runs),
        n_new=n_new,
        friction_min=min(friction),
        friction_max=max(friction),
        volume_min_m3=min(volume),
        volume_max_m3=max(volume),
        stop_min_x_m=min(stops, default=None),
        stop_max_x_m=max(stops, default=None),
        left=sum(one.left_profile for one in runs),
        seconds=float(np.mean([one.seconds for one in runs])),
    )


PRESSURES_KPA = (3.0, 10.0, 30.0)
N_PLACES = 200
BY_BLOCK, BY_FLOW = 1.0, 2.0
"""Values of the band `engine`."""


@dataclass(slots=True, eq=False)
class MapPart:
    """A path on the map: chances `[n_rows, n_columns]` by band on its ground, with their limits.

    `place` `[n_rows, n_columns]` (m) is where its cells are along the line, nan far from it. Of a
    path without runs there is the chance (5, 50, 95 %) at places `x` (m) along its line.
    """

    one: MappedPath
    crop: TerrainCrop
    runs: list[Simulation]
    bands: dict[str, Floats] = field(default_factory=dict)
    x: Floats = field(default_factory=lambda: np.empty(0))
    place: Floats = field(default_factory=lambda: np.empty(0))

    def runout(self, band: str, return_period_years: float) -> float | None:
        """The farthest place (m) along the line that is come to once in the period, if any."""
        there = self.place[self.bands[band] >= 1.0 / return_period_years]
        return float(np.nanmax(there)) if np.isfinite(there).any() else None


def draw_map(
    database: str, name: str, file: FilePath, request: MapRequest, report: Report = silent
) -> ChanceMap:
    """Write a map by the model `name` to `file`: `.tif` the chances, `.gpkg` areas and zones.

    Raises `AvahazardError` where there is no such model or path, no path has terrain, the scatter
    of the model is in metres, or `file` has another ending or is somebody else's.
    """
    require_packages()
    from avahazard.gis.map_files import grid_of  # noqa: PLC0415

    if file.suffix.lower() not in (".tif", ".tiff", ".gpkg"):
        raise AvahazardError(
            f"{file} does not end in .tif or .gpkg.", "The ending says what is written."
        )
    limits = load_limits(request.limits)
    model, records = load_stored(database, name, request.effect_files)
    parts, left_out = map_parts(database, model, records, request, limits, report)
    grid = grid_of([part.crop for part in parts])
    notes = []
    if model.specification.forward == BLOCK and any(part.runs for part in parts):
        notes.append(Note("friction_of_block", model=name))
    if left_out:
        notes.append(Note("not_on_map", paths=", ".join(left_out)))
    notes += (*notes_of_fit(model), *map(Note.ready, limits.notes))
    if file.suffix.lower() == ".gpkg":
        bands = _write_areas(file, parts, limits)
    else:
        bands = _write_chances(file, grid, parts)
    rows = []
    for part in parts:
        engine, most = ENGINE if part.runs else BLOCK, np.nanmax(part.bands["chance"], initial=0.0)
        rows.append(MappedBy(part.one.path.path_id, engine, len(part.runs), float(most)))
    return ChanceMap(name, str(file), grid.crs, grid.transform.a, bands, Rows(rows), tuple(notes))


def map_parts(
    database: str,
    model: FittedModel,
    records: Records,
    request: MapRequest,
    limits: ZoneSystem,
    report: Report = silent,
) -> tuple[list[MapPart], list[str]]:
    """The paths on a map with their chances, and the names of those left out; see `draw_map`.

    Raises `AvahazardError` where the model has no scatter of friction, or no path can be drawn.
    """
    require_friction_scatter(model)
    with reading(database) as session:
        known = survey(session)
        named = known.paths_to_run(request.paths)
        crops = {path_id: load_terrain(session, path_id) for path_id in named}
        runs = load_simulations(session, lambda c: c.in_(named), peaks=True)
    flows = model.specification.forward != BLOCK
    frequencies = volume_frequencies(known.volumes, request.seed, request.source)
    by_name = {path.path_id: path for path in records.paths}
    parts: list[MapPart] = []
    left_out: list[str] = []
    for k, path_id in enumerate(named):
        report("Drawing the map", k / len(named))
        path, crop = by_name[path_id], crops[path_id]
        part = None if crop is None else _part(records, path, crop, runs)
        if part is None or (flows and not part.runs):
            left_out.append(path_id)
            continue
        volumes = frequencies.volumes(path_id, by_volume=not model.ignores_volume)
        avalanches = path_hazard(model, records, path_id, volumes, seed=request.seed).avalanches
        _fill(part, avalanches, limits)
        parts.append(part)
    report("Drawing the map", 1.0)
    if not parts:
        raise AvahazardError(
            f"There is nothing to draw: {', '.join(left_out)} have no terrain"
            f"{' or no runs' if flows else ''}.",
            "Import lines with --dem; then run: avahazard simulate.",
        )
    return parts, left_out


def _part(
    records: Records, path: Path, crop: TerrainCrop, runs: Sequence[Simulation]
) -> MapPart | None:
    """A path with its runs on its present ground; None where it has no line."""
    one = drawn_path(records, path)
    if isinstance(one, str):
        return None
    digest = ground_of(path, find_profile(records, path), crop)
    selected = [run for run in runs if run.path_id == path.path_id and run.ground == digest]
    least = min((run.drag_per_m for run in selected), default=0.0)
    return MapPart(one, crop, [run for run in selected if run.drag_per_m == least])


def _fill(part: MapPart, avalanches: Avalanches, limits: ZoneSystem) -> None:
    if not part.runs:
        part.x, chances = reach(avalanches, N_PLACES)
        part.bands = dict(zip(("chance_q05", "chance", "chance_q95"), chances, strict=True))
        return
    from avahazard.gis.avaframe_project import STOP_KPA, ground  # noqa: PLC0415 (may be missing)

    part.place = place = ground(part.one.line, part.crop).place
    pressures = {rule.pressure_kpa_min for zone in limits.zones for rule in zone.rules} - {0.0}

    def chance(limit: float) -> Floats:
        field_ = friction_field(part.runs, place, limit)
        return annual_chance(avalanches, field_).reshape(3, *part.crop.elevation_m.shape)

    names = ("chance", "chance_q05", "chance_q95")
    part.bands = dict(zip(names, chance(STOP_KPA), strict=True))
    for kpa in sorted({*PRESSURES_KPA, *pressures}):
        part.bands[_band(kpa)] = chance(kpa)[0]


def _band(kpa: float) -> str:
    return f"chance_{kpa:g}_kpa"


def _write_chances(file: FilePath, grid: MapGrid, parts: Sequence[MapPart]) -> tuple[str, ...]:
    """Write the bands; where paths overlap, that any of them comes."""
    from avahazard.gis import map_files  # noqa: PLC0415 (may be missing)

    names = ("chance", "chance_q05", "chance_q95", *map(_band, PRESSURES_KPA), "engine")
    bands = {name: np.full(grid.shape, np.nan, np.float32) for name in names}
    for part in parts:
        width = part.one.width_m or DEFAULT_WIDTH_M
        for name in [name for name in names if name in part.bands]:
            if part.runs:
                selected = map_files.on_grid(grid, part.crop, part.bands[name])
            else:
                chances = part.bands[name]
                selected = map_files.strip_on_grid(grid, part.one, part.x, chances, width)
            bands[name] = _either(bands[name], selected)
            if name == "chance":
                by = np.where(np.isfinite(selected), BY_FLOW if part.runs else BY_BLOCK, np.nan)
                bands["engine"] = np.fmax(bands["engine"], by.astype(np.float32))
    replace_file(file, map_files.is_own_raster, map_files.write_raster, grid, bands)
    return tuple(bands)


def _either(first: NDArray[np.float32], other: NDArray[np.float32]) -> NDArray[np.float32]:
    """The chance that one of two comes; of one alone where the other is unknown."""
    both = 1.0 - (1.0 - first) * (1.0 - other)
    return np.where(np.isfinite(both), both, np.fmax(first, other)).astype(np.float32)


def _write_areas(file: FilePath, parts: Sequence[MapPart], limits: ZoneSystem) -> tuple[str, ...]:
    """Write the areas of return periods, the zones, and the lines; of paths with runs."""
    from avahazard.gis import map_files  # noqa: PLC0415 (may be missing)
    from avahazard.gis.hazard_map import hazard_layers, layers_by_system  # noqa: PLC0415

    reached, band, zones = [], [], []
    for part in parts:
        if not part.runs:
            continue
        grid, line = map_files.grid_of([part.crop]), part.one.line
        about = {"path_id": part.one.path.path_id, "engine": ENGINE}
        for period in PERIOD_COLORS:
            told = {**about, "return_period_years": period, "period": f"{period:g} years"}
            reached += map_files.areas(grid, part.bands["chance"] >= 1.0 / period, line, told)
            for q in ("q95", "q05"):
                inside = part.bands[f"chance_{q}"] >= 1.0 / period
                band += map_files.areas(grid, inside, line, {**told, "quantile": q})
        taken = np.zeros(grid.shape, np.bool_)
        for zone in limits.zones:
            inside = np.zeros(grid.shape, np.bool_)
            for rule in zone.rules:
                band_of = _band(rule.pressure_kpa_min) if rule.pressure_kpa_min else "chance"
                inside |= part.bands[band_of] >= 1.0 / rule.return_period_years
            told = {**about, "limits": limits.name, "zone": zone.name, "color": zone.color}
            zones += map_files.areas(grid, inside & ~taken, line, told)
            taken |= inside
    layers = [
        *layers_by_system("zone_areas", "Polygon", zones),
        *layers_by_system("return_periods", "Polygon", reached),
        *layers_by_system("return_periods_band", "Polygon", band),
        *hazard_layers([part.one for part in parts], (), ()),
    ]
    day = np.datetime64(now(), "ms")
    replace_file(file, map_files.is_own_geopackage, map_files.write_geopackage, layers, day)
    return tuple(layer.name for layer in layers)
