"""AvaFrame's com2AB on given lines, by a Python that has it (it wants a NumPy older than ours).

Reads `{"lines": [{"x_m": […], "y_m": […]}, …]}` from standard input: elevations y along straight
lines, at equal distances from the release on. Each becomes a raster of equal rows with the line
along a middle one. Writes what com2AB finds, and how long its kernel took, as JSON.
"""

from __future__ import annotations

import configparser
import json
import logging
import sys
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from avaframe.com2AB import com2AB


def main() -> None:
    """Run com2AB's kernel on every line, once unseen and once timed."""
    logging.disable(logging.CRITICAL)
    asked = json.load(sys.stdin)
    settings = configparser.ConfigParser()
    settings.read(Path(com2AB.__file__).with_name("com2ABCfg.ini"))
    parameters = com2AB.setEqParameters(settings)
    steps = [settings["ABSETUP"].getfloat(name) for name in ("distance", "dsMin")]
    lines = [prepared(line) for line in asked["lines"]]
    found = [runout(line, parameters, steps) for line in lines]
    started = time.perf_counter()
    for line in lines:
        runout(line, parameters, steps)
    seconds = time.perf_counter() - started
    json.dump({"version": version("avaframe"), "found": found, "seconds": seconds}, sys.stdout)


def prepared(line: dict) -> tuple[dict, dict, dict]:
    """The line, its split point and its raster, as com2AB wants them."""
    x, y = np.array(line["x_m"]), np.array(line["y_m"])
    cell_m = x[1] - x[0]
    header = {
        "xllcenter": 0.0,
        "yllcenter": 0.0,
        "cellsize": cell_m,
        "ncols": len(x) + 1,
        "nrows": 4,
        "nodata_value": -9999.0,
    }
    # A column more: ends must lie within the raster.
    row = np.append(y, 2.0 * y[-1] - y[-2])
    dem = {"header": header, "rasterData": np.tile(row, (4, 1))}
    # The user's split point, above which nothing is looked for: half-way down.
    split = x[int(np.argmax(y < 0.5 * (y[0] + np.min(y))))] - x[0]
    path = {"x": np.array([0.0, x[-1] - x[0]]), "y": np.full(2, cell_m), "name": ""}
    return path, {"x": np.array([split]), "y": np.array([cell_m])}, dem


def runout(line: tuple[dict, dict, dict], parameters: dict, steps: list[float]) -> dict:
    """Angles in degrees, and the places s (m from the release), None where there is none."""
    path, split, dem = line
    try:
        found = com2AB.com2ABKern(dict(path), dict(split), dem, parameters, *steps)
    except IndexError:  # no point flat enough
        return {"beta_deg": None, "alpha_deg": None, "beta_s_m": None, "runout_s_m": None}
    at = found["indAlpha"]
    return {
        "beta_deg": float(found["beta"]),
        "alpha_deg": float(found["alpha"]),
        "beta_s_m": float(found["s"][found["indBetaPoint"]]),
        "runout_s_m": None if at is None else float(found["s"][at]),
    }


if __name__ == "__main__":
    main()
