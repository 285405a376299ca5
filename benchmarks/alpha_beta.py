"""The α-β runout by our coefficients and AvaFrame's on nine real profiles: docs/alpha-beta.md.

make alpha-beta, or … -m benchmarks.alpha_beta FOLDER. The profiles are not part of the project.
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

import numpy as np

from avahazard.results.terrain import TerrainRunout
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.path import alpha_beta_paths
from avahazard.workflow.requests import AlphaBetaRequest
from benchmarks.study import DOCS, HERE, SHARED, Line, table, write_parts

ITSELF = HERE / "avaframe.json"
SETS = ("norway", "austria", "avaframe", "avaframe-small")
CELL_M, SAME_M = 5.0, 1.0
PYTHON = "AVAFRAME_PYTHON"
Found = dict[str, dict[str, TerrainRunout]]


def tables(profiles: Path) -> dict[str, str]:
    """The tables of the page on the profiles of this folder."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "profiles.db")
        init_database(database)
        import_files(database, [profiles])
        rows = alpha_beta_paths(database, None, AlphaBetaRequest(by=SETS))
        if PYTHON in os.environ:
            ITSELF.write_text(json.dumps(_itself(database), indent=1) + "\n", encoding="utf-8")
    found: Found = {}
    for row in rows:
        found.setdefault(row.path_id, {})[row.coefficients] = row
    head = ["path", "β at x, m: ours", "AvaFrame's", *(f"α °: {name}" for name in SETS),
            *(f"runout x, m: {name}" for name in SETS)]  # fmt: skip
    lines = [
        [path, *(_number(by[name].beta_x_m, 0) for name in ("austria", "avaframe")),
         *(_number(by[name].alpha_deg, 1) for name in SETS),
         *(_number(by[name].runout_x_m, 0) for name in SETS)]
        for path, by in found.items()
    ]  # fmt: skip
    return {"sets": table(head, lines), "itself": _against_itself(found)}


def _itself(database: str) -> Line:
    """What AvaFrame finds on our ground, by path."""
    with reading(database) as session:
        profiles = load_records(session).profiles
    lines = {}
    for profile in profiles:
        first, last = profile.x_m[0], profile.x_m[-1]
        x = np.linspace(first, last, int(np.ceil((last - first) / CELL_M)) + 1)
        y = np.interp(x, profile.x_m, profile.y_m)
        lines[profile.path_id] = {"x_m": x.tolist(), "y_m": y.tolist()}
    told = com2ab(list(lines.values()))
    return {"version": told["version"], "paths": dict(zip(lines, told["found"], strict=True))}


def com2ab(lines: list[Line]) -> Line:
    """What AvaFrame's com2AB finds on lines `x_m`, `y_m`, by the Python that has it."""
    words = [os.environ[PYTHON], str(HERE / "avaframe_com2ab.py")]
    asked = json.dumps({"lines": lines})
    done = subprocess.run(words, input=asked, stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(done.stdout)


def _against_itself(found: Found) -> str:
    """Our `avaframe` beside AvaFrame itself."""
    told = json.loads(ITSELF.read_text(encoding="utf-8"))
    rows, alpha, runout = [], [], []
    for path, by in found.items():
        ours, theirs = by["avaframe"], told["paths"][path]
        beta, end = (
            v if v is None else v - ours.release_x_m for v in (ours.beta_x_m, ours.runout_x_m)
        )
        pairs = ((beta, theirs["beta_s_m"], 0), (ours.alpha_deg, theirs["alpha_deg"], 1),
                 (end, theirs["runout_s_m"], 0))  # fmt: skip
        rows.append([path, *(_number(v, digits) for a, b, digits in pairs for v in (a, b))])
        if abs((beta or 0.0) - theirs["beta_s_m"]) < SAME_M:
            alpha.append(abs((ours.alpha_deg or 0.0) - theirs["alpha_deg"]))
            runout.append(abs((end or 0.0) - theirs["runout_s_m"]))
    head = ["path"]
    for what in ("β at x, m", "α °", "runout x, m"):
        head += [f"{what}: ours", "AvaFrame's"]
    return (
        f"{table(head, rows)}\n\ncom2AB of AvaFrame {told['version']}. The β-points agree within "
        f"{SAME_M:.0f} m on {len(alpha)} of {len(rows)} paths; there α differs by at most "
        f"{max(alpha):.0e}°, the runout by {max(runout):.0f} m."
    )


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


if __name__ == "__main__":
    profiles = Path(sys.argv[1]) if len(sys.argv) > 1 else SHARED / "tyrol-profiles"
    write_parts(DOCS / "alpha-beta.md", tables(profiles))
