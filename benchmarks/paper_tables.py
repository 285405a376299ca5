"""Tables 2 and 3 of Ancey (2005) beside ours on the twin.

Writes docs/paper_tables.md, and the same tables into README.md between their marks.
Run from the root of the checkout: make paper-tables
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from avahazard.results.calibration import Calibration
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files

ROOT = Path(__file__).resolve().parents[1]
PAGE, README = ROOT / "docs" / "paper_tables.md", ROOT / "README.md"
BEGIN, END = "<!-- paper tables -->\n", "<!-- end of paper tables -->\n"

# Table 2: name, path, a, n in 1e-7/m3, sigma in m, each path by itself.
BY_PATH = (
    ("Saint Clément", "saint-clement", 0.52, 2.0, 260),
    ("Gurraz", "gurraz", 0.53, 3.0, 150),
    ("Saugy", "saugy", 0.51, 4.9, 208),
    ("Scey", "scey", 0.62, 5.5, 83),
    ("Entremène", "entremene", 0.63, 0.4, 41),
    ("Nants", "nants", 0.51, 1.7, 64),
    ("Grand Chantey", "grand-chantey", 0.56, 0.3, 52),
)
# Table 3: all paths. The last column is the law that the twin was made with.
PAPER_ALL = {
    "metropolis": ("0.498 ± 0.02", "7.0 ± 2.6", "189 ± 10 m"),
    "gibbs": ("0.519 ± 0.007", "3.36 ± 0.08", "0.158 ± 0.008"),
}
NAMES = {"metropolis": "Metropolis-Hastings", "gibbs": "Gibbs", "marginal": "marginal (ours)"}


def run() -> str:
    """Calibrate on the twin and return the page."""
    with tempfile.TemporaryDirectory() as folder:
        database = str(Path(folder) / "twin.db")
        init_database(database)
        import_files(database, [ROOT / "data"])
        alone = [
            calibrate(database, path_id, method="metropolis", paths=[path_id])
            for _, path_id, *_ in BY_PATH
        ]
        together = {
            method: calibrate(database, f"all-{method}", method=method)  # type: ignore[arg-type]
            for method in NAMES
        }
    return _page(alone, together)


def _page(alone: list[Calibration], together: dict[str, Calibration]) -> str:
    lines = [
        "The paper's records were never published. Ours are the [twin](data/README.md):",
        "altitudes, numbers of events and ranges of volumes are the paper's; the events were drawn",
        "from one law for all paths, its Gibbs estimate. So ours has to come back to the law that",
        "made the twin, not to the paper's estimate for each path. n is in 1e-7/m³; ± is one",
        "standard deviation of the posterior.",
        "",
        "Table 2: each path by itself, Metropolis-Hastings, σ in metres of elevation; events that",
        "it could use.",
        "",
        "| path | events | a (paper) | a | n (paper) | n | σ (paper) | σ |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (name, _, a, n, sigma), model in zip(BY_PATH, alone, strict=True):
        found = _cells(model)
        lines.append(
            f"| {name} | {model.n_events} | {a} | {found[0]} | {n} | {found[1]} "
            f"| {sigma} m | {found[2]} |"
        )
    lines += [
        "",
        "Table 3: all paths together, by method. The twin was made with a = 0.519, n = 3.36 and",
        "σ = 0.158 on log μ. Of its 173 events, events counts those that the method could use:",
        "Metropolis-Hastings none that left its profile, Gibbs none either that no friction stops",
        "where it was recorded.",
        "",
        "| method | events | a (paper) | a | n (paper) | n | σ (paper) | σ |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for method, model in together.items():
        paper = PAPER_ALL.get(method, ("–", "–", "–"))
        cells = [c for pair in zip(paper, _cells(model), strict=True) for c in pair]
        lines.append(f"| {NAMES[method]} | {model.n_events} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _cells(model: Calibration) -> tuple[str, str, str]:
    """a, n in 1e-7/m3 and σ with their standard deviations."""
    a, n, sigma = (model.parameters[key] for key in ("a", "n", "sigma"))
    metres = sigma.unit == "m"
    return (
        f"{a.mean:.3f} ± {a.sd:.3f}",
        f"{n.mean * 1e7:.1f} ± {n.sd * 1e7:.1f}",
        f"{sigma.mean:.0f} ± {sigma.sd:.0f} m" if metres else f"{sigma.mean:.3f} ± {sigma.sd:.3f}",
    )


def main() -> None:
    """Write the page, and its text into the README."""
    tables = run()
    PAGE.parent.mkdir(exist_ok=True)
    of_docs = tables.replace("(data/README.md)", "(../data/README.md)")
    PAGE.write_text(f"# The paper's tables beside ours\n\n{of_docs}", encoding="utf-8")
    before, rest = README.read_text(encoding="utf-8").split(BEGIN)
    README.write_text(f"{before}{BEGIN}{tables}{END}{rest.split(END)[1]}", encoding="utf-8")
    print(tables)


if __name__ == "__main__":
    main()
