"""The α-β runout by our coefficients and AvaFrame's on nine real profiles: docs/alpha-beta.md.

The profiles are not part of the project: their folder is the argument, by default
../shared/data/tyrol-profiles. Run from the root of the checkout: make alpha-beta

Where AVAFRAME_PYTHON names a Python that has AvaFrame (`avaframe_com2ab.py`), AvaFrame itself is
run on the same ground, and what it finds is kept in avaframe.json; else that is what was found.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.results.terrain import TerrainRunout
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.alpha_beta import alpha_beta_paths
from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "alpha-beta.md"
PROFILES = ROOT.parent / "shared" / "data" / "tyrol-profiles"
ITSELF = ROOT / "benchmarks" / "avaframe.json"
RUNNER = ROOT / "benchmarks" / "avaframe_com2ab.py"
SETS = ("norway", "austria", "avaframe", "avaframe-small")

HEAD = """# The alpha-beta runout by four sets

`avahazard alpha-beta --by …` on nine real profiles of Tyrol (example cases of AvaFrame; terrain
Land Tirol), written by `make alpha-beta`. `norway` and `austria` take our β-point, `avaframe` and
`avaframe-small` the one and the coefficients of AvaFrame's module com2AB: its equation written
anew, and tested on parabolas by hand and on benches by a plain search.
"""
WITNESS = """## AvaFrame itself

com2AB of AvaFrame {version}, run on a raster of the same points (cells of {cell:g} m at most), with
the split point that it asks for half-way down each path. x is counted from the release.

| path | β at x, m: ours | AvaFrame's | α °: ours | AvaFrame's | runout x, m: ours | AvaFrame's |
|---|---|---|---|---|---|---|
"""
CELL_M, SAME_M, NEAR_M = 5.0, 1.0, 20.0
PYTHON = "AVAFRAME_PYTHON"


def page(profiles: Path) -> str:
    """The page on the profiles of this folder."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "profiles.db")
        init_database(database)
        import_files(database, [profiles])
        rows = alpha_beta_paths(database, by=SETS)
        if PYTHON in os.environ:
            ITSELF.write_text(json.dumps(_itself(database), indent=1) + "\n", encoding="utf-8")
    found: dict[str, dict[str, TerrainRunout]] = {}
    for row in rows:
        found.setdefault(row.path_id, {})[row.coefficients] = row
    lines = [
        "| path | β at x, m: ours | AvaFrame's | "
        + " | ".join(f"α °: {name}" for name in SETS)
        + " | "
        + " | ".join(f"runout x, m: {name}" for name in SETS)
        + " |",
        "|" + "---|" * (3 + 2 * len(SETS)),
    ]
    for path, by in found.items():
        cells = [_number(by["austria"].beta_x_m, 0), _number(by["avaframe"].beta_x_m, 0)]
        cells += [_number(by[name].alpha_deg, 1) for name in SETS]
        cells += [_number(by[name].runout_x_m, 0) for name in SETS]
        lines.append(f"| {path} | {' | '.join(cells)} |")
    return "\n".join((HEAD, *lines, "", _in_words(found), "", _witness(found))) + "\n"


def _itself(database: str) -> dict[str, Any]:
    """What AvaFrame finds on our ground, by path."""
    with reading(database) as session:
        profiles = load_records(session).profiles
    lines = {}
    for profile in profiles:
        first, last = profile.x_m[0], profile.x_m[-1]
        x = np.linspace(first, last, int(np.ceil((last - first) / CELL_M)) + 1)
        y = np.interp(x, profile.x_m, profile.y_m)
        lines[profile.path_id] = {"x_m": x.tolist(), "y_m": y.tolist()}
    done = subprocess.run(
        [os.environ[PYTHON], str(RUNNER)],
        input=json.dumps({"lines": list(lines.values())}),
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    told = json.loads(done.stdout)
    return {"version": told["version"], "paths": dict(zip(lines, told["found"], strict=True))}


def _witness(found: dict[str, dict[str, TerrainRunout]]) -> str:
    """Our `avaframe` beside AvaFrame itself."""
    told = json.loads(ITSELF.read_text(encoding="utf-8"))
    rows, alpha, runout = [], [], []
    for path, by in found.items():
        ours, theirs = by["avaframe"], told["paths"][path]
        start = ours.release_x_m
        places = [v if v is None else v - start for v in (ours.beta_x_m, ours.runout_x_m)]
        cells = [_number(v, 0) for v in (places[0], theirs["beta_s_m"])]
        cells += [_number(v, 1) for v in (ours.alpha_deg, theirs["alpha_deg"])]
        cells += [_number(v, 0) for v in (places[1], theirs["runout_s_m"])]
        rows.append(f"| {path} | {' | '.join(cells)} |")
        if abs((places[0] or 0.0) - theirs["beta_s_m"]) < SAME_M:
            alpha.append(abs((ours.alpha_deg or 0.0) - theirs["alpha_deg"]))
            runout.append(abs((places[1] or 0.0) - theirs["runout_s_m"]))
    return (
        WITNESS.format(version=told["version"], cell=CELL_M)
        + "\n".join(rows)
        + f"\n\nThe β-point is one place within {SAME_M:.0f} m on {len(alpha)} of {len(rows)} "
        f"paths; there α differs by {max(alpha):.0e}° at most, the runout by {max(runout):.0f} m: "
        "its runout is the upper end of the step in which ours lies."
    )


def _in_words(found: dict[str, dict[str, TerrainRunout]]) -> str:
    near, far = [], []
    for path, by in found.items():
        ours, theirs = by["austria"], by["avaframe"]
        if ours.alpha_deg is None or theirs.alpha_deg is None:
            continue
        lower = (theirs.beta_x_m or 0.0) - (ours.beta_x_m or 0.0)
        difference = abs(ours.alpha_deg - theirs.alpha_deg)
        (near if abs(lower) < NEAR_M else far).append((path, lower, difference))
    middle = np.median([d for _, _, d in near])
    text = (
        f"On {len(near)} of {len(found)} paths both β-points are one place within {NEAR_M:.0f} m; "
        f"there α of `austria` and `avaframe` differ by {middle:.1f}° in the median, "
        f"{max(d for _, _, d in near):.1f}° at most (standard deviations are 1.5° and 1.25°)."
    )
    if far:
        text += " Elsewhere AvaFrame's, which is one of the points as they are, lies " + ", ".join(
            f"{abs(lower):.0f} m {'below' if lower > 0.0 else 'above'} ours on `{path}` (α differs "
            f"by {difference:.1f}°)"
            for path, lower, difference in far
        )
        text += "."
    return (
        f"{text}\n\n`avaframe-small` adds 0.0088° for each metre of the fall, so that on large "
        "paths like these its α is above β, and the runout lies in the track: it is for small "
        "avalanches."
    )


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    PAGE.write_text(page(Path(sys.argv[1]) if len(sys.argv) > 1 else PROFILES))
