"""The held-out error from model to model, down to the floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.report.picture import picture


def draw_ladder(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw the rows of `ladder` to `file`; models that were not compared are left out.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    shown = [row for row in rows if row["held_out_crps_m"] is not None]
    level = {row["model"]: row["held_out_crps_m"] for row in shown}
    with picture(file) as axes:
        for k, row in enumerate(shown):
            value = row["held_out_crps_m"]
            before = level.get(row["parent"])
            axes.bar(k, value, color="0.75", width=0.6)
            if before is not None:
                # What the child gained or lost against its parent.
                color = "tab:green" if value < before else "tab:red"
                axes.bar(k, before - value, bottom=value, color=color, alpha=0.6, width=0.6)
            axes.annotate(f"{value:.0f} m", (k, value), ha="center", va="top", fontsize=8)
        floors = [row["noise_floor_crps_m"] for row in shown]
        if floors:
            axes.axhline(min(floors), color="tab:blue", linestyle="--", label="error of records")
            axes.legend(loc="upper right")
        axes.margins(y=0.08)
        axes.set_xticks(np.arange(len(shown)), [_label(row) for row in shown], fontsize=8)
        axes.set_ylabel("held-out CRPS (m)")


def _label(row: Mapping[str, Any]) -> str:
    added = "\n".join(f"+ {key}" for key in row["added"])
    return f"{row['model']}\n{added}" if added else str(row["model"])
