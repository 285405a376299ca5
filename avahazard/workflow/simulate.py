"""Runs of a flow model on the terrain of paths, over friction and volume: made, stored, resumed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

import numpy as np

from avahazard.arrays import Floats
from avahazard.engine import spread_map
from avahazard.engines.com1dfa import ENGINE, find_python, simulate
from avahazard.gis import require_packages
from avahazard.notes import Note
from avahazard.records.collection import Records, Simulation, find_path, find_profile, ground_of
from avahazard.records.errors import AvahazardError
from avahazard.results.base import Report, Rows, silent
from avahazard.results.terrain import SimulatedPath, SimulationPlan, Simulations
from avahazard.store.records import load_records, load_simulations, load_terrain, save_simulation
from avahazard.store.session import reading, writing
from avahazard.workers import n_workers
from avahazard.workflow.export import drawn_path
from avahazard.workflow.requests import SimulateRequest

if TYPE_CHECKING:
    from avahazard.gis.avaframe_project import Ground

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
