"""Candidate effects with what chance alone would show."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from avahazard.report.picture import picture
from avahazard.results.diagnosis import Candidate, Diagnosis

MOST_ROWS = 16
SIGNIFICANT = 0.03
# Told apart by colour-blind readers too; the band of chance stands out against all.
NAMED, NOTED, OTHER, CHANCE = "#d95f02", "#e6ab02", "0.45", "tab:blue"
TICKS = (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def draw_diagnosis(file: Path, diagnosis: Diagnosis) -> None:
    """Draw a diagnosis to `file`: a bar of gain for every candidate.

    With the band that chance alone stays within in 19 of 20 worlds in which the model is true, and
    the p-value that allows for the number of candidates.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    from matplotlib.patches import Patch  # noqa: PLC0415 (slow)

    rows = list(reversed(diagnosis.candidates[:MOST_ROWS]))
    named = set(diagnosis.missing)
    with picture(file) as axes:
        for k, row in enumerate(rows):
            gain, chance = row.screened_gain, row.chance_gain
            axes.barh(k, chance, height=0.86, color=CHANCE, alpha=0.22)
            axes.barh(k, gain, height=0.42, color=_color(row, named))
            axes.annotate(
                f"p = {row.p_value:.{2 if row.p_value >= 0.095 else 3}f}",
                (max(gain, chance), k),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
                color="black" if row.p_value <= SIGNIFICANT else "0.45",
            )
        axes.set_yticks(np.arange(len(rows)), [r.effect for r in rows], fontsize=9)
        axes.set_xscale("symlog", linthresh=2.0)
        most = max((max(r.screened_gain, r.chance_gain) for r in rows), default=1.0)
        axes.set_xlim(0.0, max(2.0, most) * 1.6)
        ticks = [tick for tick in TICKS if tick <= most * 1.6]
        axes.set_xticks(ticks, [str(tick) for tick in ticks], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("gain in log likelihood (nats); law, scatter and paths fitted again")
        axes.set_title(_title(diagnosis))
        axes.spines[["top", "right"]].set_visible(False)
        colors = {_color(row, named) for row in rows}
        patches = [
            Patch(color=color, label=label)
            for color, label in (
                (NAMED, "named"),
                (NOTED, f"p ≤ {SIGNIFICANT:g} among so many candidates"),
                (OTHER, "could be chance"),
            )
            if color in colors
        ]
        band = Patch(color=CHANCE, alpha=0.22, label="chance alone, 19 times in 20")
        axes.legend(handles=[*patches, band], loc="lower right", fontsize=8)


def _color(row: Candidate, named: set[str]) -> str:
    if row.effect in named:
        return NAMED
    return NOTED if row.p_value <= SIGNIFICANT else OTHER


def _title(diagnosis: Diagnosis) -> str:
    model, missing = diagnosis.model, ", ".join(diagnosis.missing)
    if diagnosis.cannot_tell:
        return f"{model}: these data cannot tell whether it lacks an effect"
    return {
        "adequate": f"{model} is adequate",
        "missing-effect": f"{model} lacks {missing}",
        "ambiguous": f"{model} lacks one of {missing}",
    }.get(diagnosis.verdict, f"{model} fails along {missing}")
