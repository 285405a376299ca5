"""The results of a model as files for a GIS or a spreadsheet."""

from __future__ import annotations

import csv
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from avahazard.arrays import Floats, Ints
from avahazard.effects.site import release_place, stop_place
from avahazard.engines.com1dfa import settings_of
from avahazard.hazard.exceedance import Avalanches
from avahazard.hazard.frequency import volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.inference.model import friction_scatter
from avahazard.inference.model.choices import BLOCK
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.physics.smooth_profile import smooth_profile
from avahazard.records.collection import Path, Records, of_path
from avahazard.records.errors import AvahazardError
from avahazard.report import hazard_tables
from avahazard.results.base import Report, Rows, plain, silent
from avahazard.results.files import Export, Layer
from avahazard.results.hazard import HazardRow
from avahazard.store import results as store
from avahazard.store.records import load_records, load_simulations
from avahazard.store.session import reading
from avahazard.whole_file import put_in_place
from avahazard.workflow.by_path import survey
from avahazard.workflow.requests import AvaframeRequest, SimulateRequest
from avahazard.workflow.simulate import RunPath, ready_paths
from avahazard.workflow.stored import load_stored, notes_of, notes_of_fit, require_friction_scatter

if TYPE_CHECKING:
    from avahazard.gis.hazard_map import MapLayer, MappedPath

ENDINGS = (".gpkg", ".geojson", ".csv", ".xlsx", ".parquet")
TABLES = {
    ".csv": (hazard_tables.is_own_csv, hazard_tables.write_hazard),
    ".xlsx": (hazard_tables.is_own_workbook, hazard_tables.write_hazard_workbook),
}


def export(database: str, name: str, file: FilePath) -> Export:
    """Write the latest bounds and zones by the model `name` to `file`, for what its name ends in.

    `.gpkg`: paths, releases, recorded stops, runouts and zones as layers with their styles, in the
    paths' own reference systems; `.geojson`: the same on WGS 84; `.csv`, `.xlsx`: the rows of
    `hazard`; `.parquet`: the same, with the place of design runouts on the map. A file that an
    export made before is replaced, no other one. Raises `AvahazardError` where there is no such
    model, no bounds are stored by it, `file` has another ending or is somebody else's, or no path
    has coordinates.
    """
    ending = file.suffix.lower()
    if ending not in ENDINGS:
        raise AvahazardError(
            f"{file} does not end in {', '.join(ENDINGS)}.",
            "The ending says what is written: GeoPackage, GeoJSON or a table.",
        )
    if ending == ".parquet":
        return _parquet(database, name, file)
    with reading(database) as session:
        model = store.load_model(session, name)
        rows = store.latest_documents(session, store.BOUNDS, name)
        zones = store.latest_documents(session, store.ZONES, name)
        records = load_records(session)
        known = notes_of(model, records)
    if not rows:
        raise _no_bounds(name)
    bounds = [_bounds(row, known) for row in rows]
    if ending in TABLES:
        is_own, write = TABLES[ending]
        replace_file(file, is_own, lambda part: write(part, bounds))
        return Export(name, str(file), Rows([Layer("hazard", len(rows), None)]), known)
    made, notes = map_layers(records, plain(bounds), zones or [])
    notes = [*known, *notes]
    if zones is None:
        notes.append(f"no zones are stored by {name}: avahazard zones {name}")
    from avahazard.gis import map_files  # noqa: PLC0415 (may be missing)

    if ending == ".gpkg":
        day = np.datetime64(store.now(), "ms")
        write = partial(map_files.write_geopackage, layers=made, day=day)
        replace_file(file, map_files.is_own_geopackage, write)
    else:
        replace_file(file, map_files.is_own_geojson, partial(map_files.write_geojson, layers=made))
    layers = Rows(Layer(m.name, len(m.features), m.code) for m in made)
    return Export(name, str(file), layers, tuple(notes))


def _parquet(database: str, name: str, file: FilePath) -> Export:
    """Write the rows as Parquet, a few in memory at a time."""
    hazard_tables.require_parquet()
    with reading(database) as session:
        model = store.load_model(session, name)
        run = store.latest_run(session, store.BOUNDS, name)
        if run is None:
            raise _no_bounds(name)

        known = notes_of(model, load_records(session))

        def rows() -> Iterator[HazardRow]:
            for found in store.read_run(session, run.id):
                yield from (_bounds(row, known) for row in found.documents)

        n_rows = n_places = 0

        def write(part: FilePath) -> None:
            nonlocal n_rows, n_places
            n_rows, n_places = hazard_tables.write_hazard_parquet(part, rows)

        replace_file(file, hazard_tables.is_own_parquet, write)
    notes = () if n_places else ("no design runout has a place on the map: there is no geometry.",)
    return Export(name, str(file), Rows([Layer("hazard", n_rows, None)]), notes)


def _no_bounds(name: str) -> AvahazardError:
    return AvahazardError(
        f"No bounds are stored by {name}.", f"Draw them first: avahazard hazard {name}"
    )


def _bounds(row: Mapping[str, Any], known: Sequence[Note]) -> HazardRow:
    """A stored row, with its notes when it was computed, and what is known of its model today."""
    notes = (*map(Note.read, row.get("notes", ())), *known)
    return HazardRow.from_dict({**row, "notes": tuple(dict.fromkeys(notes))})


def replace_file(
    file: FilePath, is_own: Callable[[FilePath], bool], write: Callable[[FilePath], None]
) -> None:
    """Write beside `file` and put it in its place when it is whole."""
    if not file.parent.is_dir():
        raise AvahazardError(f"There is no folder {file.parent}.", "Make the folder first.")
    if file.exists() and not (file.is_file() and is_own(file)):
        raise AvahazardError(
            f"{file} is there already, and no export made it; nothing was written.",
            "Name another file, or remove that one first.",
        )
    part = file.with_name(f".{file.stem}.part{file.suffix}")
    part.unlink(missing_ok=True)
    try:
        write(part)
        put_in_place(part, file)
    finally:
        part.unlink(missing_ok=True)


Documents = Sequence[Mapping[str, Any]]


def map_layers(
    records: Records, rows: Documents, zones: Documents
) -> tuple[list[MapLayer], list[str]]:
    """The layers, and notes on what has no place on them; `rows` and `zones` are documents.

    Raises `AvahazardError` where no path has coordinates.
    """
    from avahazard.gis import require_packages  # noqa: PLC0415 (may be missing)

    require_packages()
    from avahazard.gis.hazard_map import hazard_layers  # noqa: PLC0415

    drawn: list[MappedPath] = []
    lacking: dict[str, list[str]] = {}
    for path in records.paths:
        one = drawn_path(records, path)
        if isinstance(one, str):
            lacking.setdefault(one, []).append(path.path_id)
        else:
            drawn.append(one)
    reasons = [f"{', '.join(paths)}: {reason}" for reason, paths in lacking.items()]
    if not drawn:
        raise AvahazardError(
            f"No path can be drawn on a map ({'; '.join(reasons) or 'there are none'}).",
            "Give profiles.csv easting_m, northing_m and crs, or lon and lat, and import it with "
            "--update; or import the paths as lines with --dem. A .csv needs no coordinates.",
        )
    notes = [f"not on the map are {reason}" for reason in reasons]
    return hazard_layers(drawn, rows, zones), notes + _notes(drawn, rows, zones)


def drawn_path(records: Records, path: Path) -> MappedPath | str:
    """A path on the map with its recorded stops, or what it lacks for that."""
    from avahazard.gis.hazard_map import MappedPath, path_line  # noqa: PLC0415

    mine = of_path(records, path.path_id)
    if not mine.profiles:
        return "no profile"
    (profile,), events = mine.profiles, mine.events
    if isinstance(line := path_line(profile), str):
        return line
    smooth = smooth_profile(profile.x_m, profile.y_m, profile.elevation_sigma_m)
    stops = [(event, x) for event in events if (x := stop_place(smooth, event)) is not None]
    return MappedPath(path, line, release_place(smooth, path.release_elevation_m), tuple(stops))


def _notes(drawn: Sequence[MappedPath], rows: Documents, zones: Documents) -> list[str]:
    """What has no place on the map."""
    from avahazard.gis.hazard_map import QUANTILES  # noqa: PLC0415 (may be missing)

    shown = {one.path.path_id for one in drawn}
    beyond = [
        row["path_id"]
        for row in rows
        for found in (row, row.get("design"))
        if found and row["path_id"] in shown
        for quantile in QUANTILES
        if found["runout_x_m"][quantile] is None
    ]
    notes = []
    if beyond:
        notes.append(
            f"{len(beyond)} quantiles of runouts lie past the end of the profile and have no "
            f"point: {', '.join(dict.fromkeys(beyond))}. Longer profiles would tell."
        )
    bare = [
        one.path.path_id
        for one in drawn
        if one.width_m is None and any(z["path_id"] == one.path.path_id for z in zones)
    ]
    if bare:
        notes.append(f"zones as lines only, for want of a column width_m: {', '.join(bare)}.")
    return notes


DRAWS, TABLE, RUNNER = "draws", "draws.csv", "run_draws.py"
LEAST_FRICTION = 0.001
"""Normal friction may be drawn at 0 or below: what has so little goes as far."""
COLUMNS = ("draw", "release", "volume_m3", "thickness_m", "friction", "drag_per_m", "per_year")
PROGRAM = '''"""A probability run: com1DFA for each draw, and the share that comes to each cell.

Start this file with the Python of AvaFrame; the map is then in Outputs/ana4Stats.
"""

from pathlib import Path

from avaframe.ana4Stats import probAna
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils, initializeProject, logUtils

if __name__ == "__main__":
    folder = Path(__file__).resolve().parent
    settings = cfgUtils.getGeneralConfig()
    settings["MAIN"]["avalancheDir"] = str(folder)
    logUtils.initiateLogger(folder, "run_draws")
    initializeProject.cleanSingleAvaDir(folder, deleteOutput=False)
    com1DFA.com1DFAMain(settings, cfgInfo=folder / "draws")
    done, _ = cfgUtils.readAllConfigurationInfo(folder, specDir="", configCsvName="latestSims")
    asked = cfgUtils.getModuleConfig(probAna, folder)
    probAna.probAnalysis(folder, asked, "com1DFA", parametersDict="", simDFActual=done)
'''


class Futures(NamedTuple):
    """Future avalanches, `[n]` each: their volumes (m3), frictions and drags (1/m).

    Each stands for `per_year` avalanches a year: the sum over those that come to a place is its
    yearly rate.
    """

    volume: Floats
    friction: Floats
    drag: Floats
    per_year: Floats


def export_avaframe(
    database: str, name: str, folder: FilePath, request: AvaframeRequest, report: Report = silent
) -> Export:
    """Write an AvaFrame project for each path with terrain, into a new `folder`.

    `com1DFACfg.ini` has the median volume of an avalanche and the median friction at it; `draws`
    the settings of future avalanches, each as likely, over volumes, scatter and the uncertainty
    of the parameters. Releases are those of `simulate`, and drag is that of its runs, or of a model
    of the block. Raises `AvahazardError` where there is no such model or path, no path has terrain,
    the scatter of the model is in metres, or `folder` holds something.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise AvahazardError(f"{folder} is there already.", "Name a new folder, or an empty one.")
    if not folder.absolute().parent.is_dir():
        raise AvahazardError(f"There is no folder {folder.parent}.", "Make the folder first.")
    model, records = load_stored(database, name, request.effect_files)
    require_friction_scatter(model)
    # Volumes are drawn: that of the request only says that none need be recorded.
    asked = SimulateRequest(paths=request.paths, volumes=(1.0,), release=request.release)
    paths, notes = ready_paths(database, asked)
    with reading(database) as session:
        known = survey(session)
        runs = load_simulations(session)
    # The least of a path is the last that is put there.
    by_drag = sorted(runs, key=lambda one: -one.drag_per_m)
    drags = {(one.path_id, one.ground): one.drag_per_m for one in by_drag}
    frequencies = volume_frequencies(known.volumes, request.seed, request.source)
    flows = model.specification.forward != BLOCK
    whole = folder.resolve()
    part = whole.with_name(f".{whole.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    try:
        for k, path in enumerate(paths):
            report("Writing AvaFrame projects", k, len(paths))
            path_id = path.path_id
            # Volume matters to the flow even where friction does not change with it.
            volumes = frequencies.of(path_id).volumes()
            found = path_hazard(model, records, path_id, volumes, seed=request.seed).avalanches
            drag = drags.get((path_id, path.digest), 0.0) if flows else None
            rng = generator(request.seed, "avaframe", path_id)
            middle, drawn = _middle(found, drag), _drawn(found, request.draws, drag, rng)
            own = part / re.sub(r"[^\w-]", "_", path_id)
            _write(own if not own.exists() else part / f"{own.name}_{k}", path, middle, drawn)
        if folder.exists():
            folder.rmdir()
        part.rename(whole)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    report("Writing AvaFrame projects", len(paths), len(paths))
    told = [*notes_of_fit(model), *notes]
    if not flows:
        told.insert(0, Note("friction_of_block", model=name))
    layers = Rows([Layer(p.path_id, request.draws, p.ground.crop.crs) for p in paths])
    return Export(name, str(folder), layers, tuple(told))


def _drawn(avalanches: Avalanches, n: int, drag: float | None, rng: np.random.Generator) -> Futures:
    """Future avalanches, whose volumes are spread as evenly as so many can be."""
    draw = np.linspace(0, avalanches.n_parameters - 1, n).astype(np.int64)
    level = rng.permutation((np.arange(n) + rng.uniform()) / n)
    total = np.cumsum(avalanches.share[draw], axis=1)
    node = np.sum(total < level[:, None] * total[:, -1:], axis=1)
    of_class = rng.choice(avalanches.n_classes, n, p=avalanches.class_share)
    at = draw, of_class, node
    z = friction_scatter.draws(rng, n, avalanches.student)
    friction = friction_scatter.friction(
        avalanches.location[at], avalanches.scatter[at] * z, avalanches.in_log
    )
    volume = np.exp(avalanches.volumes.log_volume[node % len(avalanches.volumes.log_volume)])
    per_year = avalanches.volumes.rate[draw] / n
    return Futures(
        volume, np.maximum(friction, LEAST_FRICTION), _drags(avalanches, draw, drag), per_year
    )


def _middle(avalanches: Avalanches, drag: float | None) -> Futures:
    """The one avalanche of median volume, and of the median friction at it."""
    n_volumes = len(avalanches.volumes.log_volume)
    share = np.mean(avalanches.volumes.share, axis=0)
    node = int(np.searchsorted(np.cumsum(share), 0.5 * share.sum()))
    location = float(np.median(avalanches.location[:, :, node::n_volumes]))
    friction = np.exp(location) if avalanches.in_log else location
    every = np.arange(avalanches.n_parameters)
    volume = np.exp(avalanches.volumes.log_volume[[node]])
    slowed = float(np.median(_drags(avalanches, every, drag)))
    rate = float(np.mean(avalanches.volumes.rate))
    return Futures(volume, np.array([friction]), np.array([slowed]), np.array([rate]))


def _drags(avalanches: Avalanches, draw: Ints, drag: float | None) -> Floats:
    """Drag (1/m) of some draws: the one that is given, else the block's, over all of its cells."""
    if drag is not None:
        return np.full(len(draw), drag)
    of_group = np.array([np.mean(one.drag) for one in avalanches.resistances])
    return np.asarray(of_group[avalanches.group[draw]])


def _write(folder: FilePath, path: RunPath, middle: Futures, drawn: Futures) -> None:
    """Write the project of a path."""
    from avahazard.gis.avaframe_project import (  # noqa: PLC0415 (may be missing)
        thickness_of,
        write_project,
        write_scenario,
    )

    def scenario(one: Sequence[float]) -> tuple[Floats, float, dict[str, object]]:
        volume, friction, drag = (float(value) for value in one[:3])
        corners = path.corners(volume)
        thickness = thickness_of(path.ground, corners, volume)
        settings = settings_of(path.ground.crop.cell_m, friction, thickness, drag)
        return corners, thickness, settings

    corners, _, settings = scenario([column[0] for column in middle])
    write_project(folder, path.ground, corners, settings)
    (folder / DRAWS).mkdir()
    (folder / RUNNER).write_text(PROGRAM, encoding="utf-8")
    with (folder / TABLE).open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for k, one in enumerate(zip(*drawn, strict=True), 1):
            corners, thickness, settings = scenario(one)
            release = f"draw{k:03d}"
            ini = f"{DRAWS}/{release}_com1DFACfg.ini"
            write_scenario(folder, path.ground.crop.crs, corners, settings, ini, release)
            volume, *rest = one
            table.writerow([k, release, *(f"{v:.6g}" for v in (volume, thickness, *rest))])
