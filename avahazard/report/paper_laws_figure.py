"""Friction against volume under several models, each with its events (figures 5 and 7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.report.html.content import FrictionView
from avahazard.report.picture import picture

# Told apart by colour-blind readers too (Okabe and Ito).
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKS = ("o", "s", "^", "D", "v", "P", "X")


@dataclass(frozen=True, slots=True, eq=False)
class ModelLaw:
    """A model's law with its scatter, and the events that it is a law of.

    `volume` (m3) and `friction`, apparent and less what effects on friction and the path add,
    are `[n_events]`.
    """

    name: str
    view: FrictionView
    volume: Floats
    friction: Floats


def draw_model_laws(file: Path, laws: Sequence[ModelLaw]) -> None:
    """Draw the median law, its 90 %, the band of 90 % of avalanches, and the events, by model.

    Events that an earlier model shows already, with the same frictions, are not drawn again.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        drawn: list[ModelLaw] = []
        for k, law in enumerate(laws):
            color, mark = COLORS[k % len(COLORS)], MARKS[k % len(MARKS)]
            view = law.view
            low, middle, high = view.law
            if not any(_same(law, other) for other in drawn):
                known = np.isfinite(law.volume) & np.isfinite(law.friction)
                axes.plot(
                    law.volume[known], law.friction[known], mark, color=color, markersize=4,
                    alpha=0.6, markeredgewidth=0, label=f"{law.name}: {int(known.sum())} events",
                )  # fmt: skip
                drawn.append(law)
            if view.scatter is not None:
                axes.fill_between(
                    view.volume, view.scatter[0], view.scatter[3], color=color, alpha=0.13,
                    linewidth=0, label=f"{law.name}: 90 % of avalanches",
                )  # fmt: skip
                for edge in (view.scatter[0], view.scatter[3]):
                    axes.plot(view.volume, edge, ":", color=color, linewidth=0.9)
            axes.plot(
                view.volume, middle, color=color, linewidth=2, label=f"{law.name}: law, median"
            )
            axes.plot(view.volume, low, "--", color=color, linewidth=0.9)
            axes.plot(
                view.volume, high, "--", color=color, linewidth=0.9, label=f"{law.name}: law, 90 %"
            )
        axes.set_xscale("log")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("volume (m³)")
        axes.set_ylabel("friction μ")
        axes.legend(fontsize="x-small", ncols=2 if len(laws) > 2 else 1)


def _same(one: ModelLaw, other: ModelLaw) -> bool:
    return (
        one.volume.shape == other.volume.shape
        and np.array_equal(one.volume, other.volume, equal_nan=True)
        and np.allclose(one.friction, other.friction, rtol=1e-3, equal_nan=True)
    )
