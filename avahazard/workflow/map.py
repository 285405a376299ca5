"""A map of annual chances: runs of a flow model mixed over friction and volumes, for a GIS.

On paths that have runs it gives in each cell the probability that an avalanche arrives, and that
its peak pressure exceeds some limits; on others the chance along the line, as wide as the flow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Floats
from avahazard.engines.com1dfa import ENGINE
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
    find_profile,
    ground_of,
)
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.terrain import PERIOD_COLORS, ChanceMap, MappedBy
from avahazard.store.records import load_simulations, load_terrain
from avahazard.store.results import now
from avahazard.store.session import reading
from avahazard.workflow.by_path import survey
from avahazard.workflow.export import drawn_path, replace_file
from avahazard.workflow.hazard import load_limits
from avahazard.workflow.requests import MapRequest
from avahazard.workflow.simulate import DEFAULT_WIDTH_M
from avahazard.workflow.stored import load_stored, notes_of_fit, require_friction_scatter

if TYPE_CHECKING:
    from avahazard.gis.hazard_map import MappedPath
    from avahazard.gis.map_files import MapGrid

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
