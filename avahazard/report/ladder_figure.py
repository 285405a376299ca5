"""The held-out error from model to model, down to the floor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avahazard.report.html.words import COORDINATES
from avahazard.report.picture import picture
from avahazard.results.ladder import Rung

WIDTH = 0.6
# Told apart by colour-blind readers too.
FELL, ROSE, LEVEL = "#1b9e77", "#d95f02", "0.82"


def draw_ladder(file: Path, rows: Sequence[Rung]) -> None:
    """Draw the rows of `ladder` to `file`, as a waterfall.

    The error of each model, and what it gained or lost against its parent. Models that were not
    compared are left out.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    shown = [(row, row.held_out_crps_m) for row in rows if row.held_out_crps_m is not None]
    place = {row.model: k for k, (row, _) in enumerate(shown)}
    with picture(file) as axes:
        for k, (row, value) in enumerate(shown):
            axes.bar(k, value, color=LEVEL, width=WIDTH)
            low = value
            at = place.get(row.parent or "")
            if at is not None:
                # From the parent's error, carried over, to the child's.
                before = shown[at][1]
                change, low = value - before, min(value, before)
                color = FELL if change < 0.0 else ROSE
                axes.bar(k, -change, bottom=value, color=color, width=WIDTH)
                axes.plot([at - WIDTH / 2, k + WIDTH / 2], [before, before], color="0.4", lw=0.8)
                sign = "−" if change < 0.0 else "+"
                text = f"{sign}{abs(change):.0f} m ({sign}{abs(change) / before:.0%})"
                axes.annotate(
                    text,
                    (k, max(value, before)),
                    (0, 3),
                    textcoords="offset points",
                    ha="center",
                    color=color,
                )
            axes.annotate(
                f"{value:.0f} m",
                (k, low),
                (0, -4),
                textcoords="offset points",
                ha="center",
                va="top",
                weight="bold",
            )
        floors = [row.noise_floor_crps_m for row, _ in shown if row.noise_floor_crps_m]
        if floors:
            axes.axhspan(0.0, min(floors), color="tab:blue", alpha=0.25, lw=0)
            axes.axhline(
                min(floors),
                color="tab:blue",
                linestyle="--",
                label=f"errors of records and volumes alone: {min(floors):.0f} m",
            )
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
        axes.margins(y=0.1)
        axes.set_ylim(bottom=0.0)
        axes.set_xticks(np.arange(len(shown)), [_label(row) for row, _ in shown])
        coordinate = (shown[0][0].coordinate if shown else None) or "mixed"
        axes.set_ylabel(f"error: CRPS where held out (m of {COORDINATES[coordinate]})")
        axes.spines[["top", "right"]].set_visible(False)


def _label(row: Rung) -> str:
    added = "\n".join(f"+ {key}" for key in row.added)
    return f"{row.model}\n{added}" if added else row.model
