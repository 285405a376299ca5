"""Candidate effects with what chance alone would show."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.report.picture import picture

MOST_ROWS = 16
SIGNIFICANT = 0.05


def draw_diagnosis(file: Path, diagnosis: Mapping[str, Any]) -> None:
    """Draw the document of `diagnose` to `file`: a bar of gain for every candidate, and the gain
    that it has in one of twenty worlds in which the model is true.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    rows = list(reversed(diagnosis["candidates"][:MOST_ROWS]))
    places = np.arange(len(rows))
    named = set(diagnosis["missing"])
    with picture(file) as axes:
        colors = [
            "tab:red"
            if r["effect"] in named
            else "tab:orange"
            if r["p_value"] <= SIGNIFICANT
            else "0.6"
            for r in rows
        ]
        axes.barh(places, [r["screened_gain"] for r in rows], color=colors, height=0.6)
        axes.barh(
            places,
            [r["chance_gain"] for r in rows],
            height=0.9,
            color="tab:blue",
            alpha=0.2,
            label="chance alone, 19 times in 20",
        )
        axes.set_yticks(places, [r["effect"] for r in rows], fontsize=8)
        axes.set_xscale("symlog", linthresh=2.0)
        axes.set_xlim(left=0.0)
        axes.set_xlabel("gain in log likelihood (nats), law, scatter and paths fitted again")
        axes.set_title(f"{diagnosis['model']}: {diagnosis['verdict']} {', '.join(named)}")
        axes.legend(loc="lower right", fontsize=8)
