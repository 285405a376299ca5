"""The pages on the paper: each figure is drawn, each argument has its test, each number holds."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from avahazard.report.picture import FORMATS
from tests.synth.test_twin import PAPER

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FIGURES = (DOCS / "paper_figures.md").read_text(encoding="utf-8")
THEORY = (DOCS / "theory" / "paper.md").read_text(encoding="utf-8")


def test_every_figure_and_table_has_a_row() -> None:
    rows = " ".join(line.split("|")[1] for line in FIGURES.splitlines() if line.startswith("| "))
    for what in ("figure 1", "figure 2", "figure 3", "F and F′", "4, 6a to c", "5, 7", "6d"):
        assert what in rows
    assert all(f"table {k}" in rows for k in (1, 2, 3))
    assert set(FORMATS) == {".png", ".svg", ".pdf"}


def test_every_test_that_a_row_names_is_there() -> None:
    named = re.findall(r"`(tests/[^`]+)`", THEORY)
    assert len(named) > 15
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_printed_error_of_n_is_out_of_reach() -> None:
    """The least error of n that any volumes within table 1 can leave, with a and σ known."""
    n, _, low, high = (np.array(column) for column in zip(*PAPER.values(), strict=True))
    assert n.sum() == 173
    middles = np.linspace(0.0, 1.2e6, 4001)[:, None]
    most = np.min(np.sum(n * np.maximum((high - middles) ** 2, (low - middles) ** 2), axis=1))
    least = 0.158 / math.sqrt(most)
    assert f"{most / 1e13:.1f} \\cdot 10^{{13}}" in THEORY
    assert f"at least {least * 1e7:.2f}e-7" in THEORY
    assert least > 2.5 * 0.08e-7
    # Nothing is larger than the bound: volumes drawn at the ends at random.
    rng = np.random.default_rng(0)
    for _ in range(200):
        ends = [
            np.where(rng.random(count) < rng.random(), top, bottom)
            for count, bottom, top in zip(n, low, high, strict=True)
        ]
        volume = np.concatenate(ends)
        assert np.sum((volume - volume.mean()) ** 2) <= most * (1.0 + 1e-6)
