"""A model and its future avalanches as AvaFrame projects, one for each path with terrain."""

import csv
import re
import tempfile
from importlib.resources import files
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np

from avahazard.arrays import Floats
from avahazard.engines.com1dfa import settings_of
from avahazard.hazard.exceedance import Avalanches
from avahazard.hazard.frequency import volume_frequencies
from avahazard.hazard.path_hazard import path_hazard
from avahazard.inference.model.choices import BLOCK
from avahazard.inference.model.friction_model import draws as scatter_draws
from avahazard.inference.model.friction_model import friction as drawn_friction
from avahazard.inference.seeds import generator
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.files import Export, Layer
from avahazard.store.records import load_simulations
from avahazard.store.session import reading
from avahazard.workflow.by_path import survey
from avahazard.workflow.flow import RunPath, ready_paths
from avahazard.workflow.requests import AvaframeRequest, SimulateRequest
from avahazard.workflow.stored import load_stored, notes_of_fit, require_friction_scatter

LEAST_FRICTION = 0.001
"""Normal friction may be drawn at 0 or below: an avalanche with this friction goes as far."""


class Future(NamedTuple):
    """A future avalanche. It represents `per_year` avalanches a year."""

    volume_m3: float
    friction: float
    drag_per_m: float
    per_year: float


def write_projects(
    database: str, name: str, folder: FilePath, request: AvaframeRequest, report: Report = silent
) -> Export:
    """Write an AvaFrame project for each path with terrain into a new `folder`.

    `com1DFACfg.ini` has the median volume of an avalanche and the median friction at it; `draws`
    the settings of future avalanches, equally likely. Releases are those of `simulate`; drag is
    that of its runs, or of a model of the block. Raises `AvahazardError` where there is no such
    model or path, no path has terrain, its scatter is in metres, or `folder` is not empty.
    """
    whole = folder.resolve()
    if whole.exists() and (not whole.is_dir() or any(whole.iterdir())):
        raise AvahazardError(f"{folder} is there already.", "Name a new folder, or an empty one.")
    if not whole.parent.is_dir():
        raise AvahazardError(f"There is no folder {folder.parent}.", "Make the folder first.")
    model, records = load_stored(database, name, request.effect_files)
    require_friction_scatter(model)
    # Volumes are drawn: that of this request only means that none need be recorded.
    asked = SimulateRequest(paths=request.paths, volumes=(1.0,), release=request.release)
    paths, notes = ready_paths(database, asked)
    with reading(database) as session:
        known = survey(session)
        runs = sorted(load_simulations(session), key=lambda run: -run.drag_per_m)
    drags = {(run.path_id, run.ground): run.drag_per_m for run in runs}  # the least of a path
    frequencies = volume_frequencies(known.volumes, request.seed, request.source)
    flows = model.specification.forward != BLOCK
    with tempfile.TemporaryDirectory(prefix=".avahazard-", dir=whole.parent) as beside:
        part = FilePath(beside) / "projects"
        for k, path in enumerate(paths):
            report("Writing AvaFrame projects", k / len(paths))
            path_id = path.path_id
            # Volume matters to the flow even where friction does not change with it.
            volumes = frequencies.of(path_id).volumes()
            found = path_hazard(model, records, path_id, volumes, seed=request.seed).avalanches
            if flows:
                drag = np.full(found.n_parameters, drags.get((path_id, path.digest), 0.0))
            else:  # the mean over the cells of the block
                drag = np.array([np.mean(one.drag) for one in found.resistances])[found.group]
            own = part / re.sub(r"[^\w-]", "_", path_id)
            own = part / f"{own.name}_{k}" if own.exists() else own
            rng = generator(request.seed, "avaframe", path_id)
            _write(own, path, _median(found, drag), _drawn(found, drag, request.draws, rng))
        if whole.exists():
            whole.rmdir()
        part.rename(whole)
    report("Writing AvaFrame projects", 1.0)
    if not flows:
        notes = (Note("friction_of_block", model=name), *notes)
    layers = Rows(Layer(p.path_id, request.draws, p.ground.crop.crs) for p in paths)
    return Export(name, str(folder), layers, (*notes, *notes_of_fit(model)))


def _median(avalanches: Avalanches, drag: Floats) -> Future:
    """The avalanche of median volume, with the median friction at it."""
    volumes = avalanches.volumes
    share = np.mean(volumes.share, axis=0)
    node = int(np.searchsorted(np.cumsum(share), 0.5 * share.sum()))
    location = np.median(avalanches.location[:, :, node :: len(share)])
    friction = np.exp(location) if avalanches.in_log else location
    volume = np.exp(volumes.log_volume[node])
    return Future(*map(float, (volume, friction, np.median(drag), np.mean(volumes.rate))))


def _drawn(avalanches: Avalanches, drag: Floats, n: int, rng: np.random.Generator) -> list[Future]:
    """Future avalanches, whose volumes are stratified."""
    draw = np.linspace(0, avalanches.n_parameters - 1, n).astype(np.int64)
    level = rng.permutation((np.arange(n) + rng.uniform()) / n)
    total = np.cumsum(avalanches.share[draw], axis=1)
    node = np.sum(total < level[:, None] * total[:, -1:], axis=1)
    at = draw, rng.choice(avalanches.n_classes, n, p=avalanches.class_share), node
    deviation = avalanches.scatter[at] * scatter_draws(rng, n, avalanches.student)
    friction = drawn_friction(avalanches.location[at], deviation, avalanches.in_log)
    volumes = avalanches.volumes
    volume = np.exp(volumes.log_volume[node % len(volumes.log_volume)])
    columns = volume, np.maximum(friction, LEAST_FRICTION), drag[draw], volumes.rate[draw] / n
    return [Future(*one) for one in zip(*columns, strict=True)]


def _write(folder: FilePath, path: RunPath, median: Future, drawn: list[Future]) -> None:
    from avahazard.gis.avaframe_project import thickness_of, write_project, write_scenario  # noqa: PLC0415 (may be missing)

    crs, cell_m = path.ground.crop.crs, path.ground.crop.cell_m

    def scenario(one: Future) -> tuple[Floats, float, dict[str, object]]:
        corners = path.corners(one.volume_m3)
        thickness = thickness_of(path.ground, corners, one.volume_m3)
        return corners, thickness, settings_of(cell_m, one.friction, thickness, one.drag_per_m)

    corners, _, settings = scenario(median)
    write_project(folder, path.ground, corners, settings)
    (folder / "draws").mkdir()
    program = files("avahazard.engines") / "run_draws.txt"
    (folder / "run_draws.py").write_bytes(program.read_bytes())
    with (folder / "draws.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("draw", "release", "thickness_m", *Future._fields))
        for k, one in enumerate(drawn, 1):
            corners, thickness, settings = scenario(one)
            name = f"draw{k:03d}"
            write_scenario(folder, crs, corners, settings, name, f"draws/{name}_com1DFACfg.ini")
            table.writerow([k, name, *(f"{value:.6g}" for value in (thickness, *one))])
