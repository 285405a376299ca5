"""AvaFrame's com1DFA: flow in two dimensions, run as a process through files.

AvaFrame needs other versions of packages than this program: it has an environment of its own,
named by `AVAHAZARD_AVAFRAME` or made by `make avaframe`, and is never imported.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from avahazard.arrays import Floats
from avahazard.physics.cells import GRAVITY
from avahazard.records.collection import Simulation
from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    from avahazard.gis.avaframe_project import Ground

ENGINE = "com1dfa"
PLACE, ENVIRONMENT = "AVAHAZARD_AVAFRAME", ".avaframe-venv"
OLDEST = (2, 1)
REMEDY = (
    "Make it with `make avaframe`, or name its Python: "
    f"{PLACE}=/path/to/environment/bin/python, with avaframe 2.1 or newer."
)
DENSITY = 200.0
"""Of the flow (kg/m3), AvaFrame's own: pressures are that times the square of speed."""


def find_python() -> FilePath:
    """The Python that has AvaFrame.

    Raises:
        AvahazardError: there is none, or its AvaFrame is missing or too old.
    """
    named = os.environ.get(PLACE)
    here = FilePath(ENVIRONMENT).absolute()
    python = FilePath(named) if named else here / "bin" / "python"
    python = python / "bin" / "python" if python.is_dir() else python
    if not python.is_file():
        raise AvahazardError(f"There is no AvaFrame here: {python} is no file.", REMEDY)
    asked = "from importlib.metadata import version; print(version('avaframe'))"
    try:
        told = subprocess.run(
            [python, "-c", asked], capture_output=True, text=True, timeout=60, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise AvahazardError(f"{python} cannot be run: {error}", REMEDY) from error
    version = told.stdout.strip()
    numbers = tuple(int(n) for n in version.split(".")[:2] if n.isdigit())
    if told.returncode or numbers < OLDEST:
        found = f"has avaframe {version}" if version else "has no AvaFrame"
        raise AvahazardError(f"{python} {found}.", REMEDY)
    return python


def settings_of(
    cell_m: float, friction: float, thickness_m: float, drag_per_m: float = 0.0
) -> dict[str, object]:
    """The settings of com1DFA for a friction, a release thickness (m) and a drag (1/m).

    Drag makes the friction Voellmy's, whose g u²/(ξ h) equals drag u² for a flow as thick as the
    release: ξ = g / (drag h).
    """
    common: dict[str, object] = {
        "simTypeList": "null",
        "relThFromFile": "False",
        "relTh": f"{thickness_m:.6g}",
        "resType": "ppr",
        "rho": f"{DENSITY:g}",
        "meshCellSize": f"{cell_m:.10g}",
    }
    if drag_per_m > 0.0:
        turbulent = GRAVITY / (drag_per_m * thickness_m)
        voellmy = {"muvoellmy": f"{friction:.6g}", "xsivoellmy": f"{turbulent:.6g}"}
        return {**common, "frictModel": "Voellmy", **voellmy}
    return {**common, "frictModel": "Coulomb", "mucoulomb": f"{friction:.6g}"}


def simulate(
    python: FilePath,
    ground: Ground,
    digest: str,
    corners: Floats,
    friction: float,
    volume_m3: float,
    drag_per_m: float = 0.0,
) -> Simulation:
    """Run com1DFA once.

    Raises:
        AvahazardError: it failed; with the last line that it printed.
    """
    from avahazard.gis.avaframe_project import read_peak, stop_of, thickness_of, write_project  # noqa: PLC0415 (may be missing)

    crop, started = ground.crop, time.monotonic()
    thickness = thickness_of(ground, corners, volume_m3)
    settings = settings_of(crop.cell_m, friction, thickness, drag_per_m)
    with tempfile.TemporaryDirectory(prefix="avahazard-") as name:
        folder = FilePath(name) / "run"
        write_project(folder, ground, corners, settings)
        told = subprocess.run(
            [python, "-m", "avaframe.runCom1DFA", str(folder)],
            cwd=name,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1"},
        )
        peak = read_peak(folder, crop) if told.returncode == 0 else None
    if peak is None:
        lines = (told.stderr or told.stdout).strip().splitlines() or ["it left no peak pressures"]
        raise AvahazardError(
            f"com1DFA failed on path {crop.path_id} with friction {friction:g} and "
            f"{volume_m3:.0f} m3: {lines[-1]}",
            "Look at the terrain and the release of the path; runs done before are kept.",
        )
    stop = stop_of(ground, peak)
    end = float(ground.x[-1])
    return Simulation(
        path_id=crop.path_id,
        engine=ENGINE,
        ground=digest,
        friction=friction,
        volume_m3=volume_m3,
        drag_per_m=drag_per_m,
        stop_x_m=stop,
        left_profile=stop >= end - crop.cell_m,
        seconds=time.monotonic() - started,
        peak_kpa=peak,
    )
