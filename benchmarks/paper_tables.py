"""Tables 2 and 3 of Ancey (2005) beside ours on the twin, into docs/paper_tables.md and the README.

make paper-tables
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from avahazard.results.calibration import Calibration
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.requests import CalibrateRequest
from benchmarks.study import DOCS, ROOT, table, write_parts

# Table 2: name, path, a, n in 1e-7/m3, sigma in m, each path by itself.
BY_PATH = (
    ("Saint Clément", "saint-clement", "0.52", "2.0", "260 m"),
    ("Gurraz", "gurraz", "0.53", "3.0", "150 m"),
    ("Saugy", "saugy", "0.51", "4.9", "208 m"),
    ("Scey", "scey", "0.62", "5.5", "83 m"),
    ("Entremène", "entremene", "0.63", "0.4", "41 m"),
    ("Nants", "nants", "0.51", "1.7", "64 m"),
    ("Grand Chantey", "grand-chantey", "0.56", "0.3", "52 m"),
)
# Table 3: all paths.
BY_METHOD = (
    ("Metropolis-Hastings", "metropolis", "0.498 ± 0.02", "7.0 ± 2.6", "189 ± 10 m"),
    ("Gibbs", "gibbs", "0.519 ± 0.007", "3.36 ± 0.08", "0.158 ± 0.008"),
    ("marginal (ours)", "marginal", "–", "–", "–"),
)
HEAD = ("events", "a (paper)", "a", "n (paper)", "n", "σ (paper)", "σ")


def tables() -> dict[str, str]:
    """Calibrate on the twin: each path by itself, then all paths by each method."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "twin.db")
        init_database(database)
        import_files(database, [ROOT / "data"])
        by_path = [
            _row(
                name,
                paper,
                calibrate(
                    database, path_id, CalibrateRequest(method="metropolis", paths=[path_id])
                ),
            )
            for name, path_id, *paper in BY_PATH
        ]
        by_method = [
            _row(name, paper, calibrate(database, f"all-{method}", CalibrateRequest(method=method)))
            for name, method, *paper in BY_METHOD
        ]
    return {
        "table 2": table(("path", *HEAD), by_path),
        "table 3": table(("method", *HEAD), by_method),
    }


def _row(name: str, paper: list[str], model: Calibration) -> tuple[object, ...]:
    """The paper's a, n in 1e-7/m3 and σ, each beside ours with its standard deviation."""
    a, n, sigma = (model.parameters[key] for key in ("a", "n", "sigma"))
    digits, unit = (0, " m") if sigma.unit == "m" else (3, "")
    ours = (
        f"{a.mean:.3f} ± {a.sd:.3f}",
        f"{n.mean * 1e7:.1f} ± {n.sd * 1e7:.1f}",
        f"{sigma.mean:.{digits}f} ± {sigma.sd:.{digits}f}{unit}",
    )
    return name, model.n_events, *(cell for pair in zip(paper, ours, strict=True) for cell in pair)


if __name__ == "__main__":
    made = tables()
    for page in (DOCS / "paper_tables.md", ROOT / "README.md"):
        write_parts(page, made)
