"""The record is the front, the block is the centre of mass."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.effects.columns import EventColumns
from avahazard.effects.effect import Definition, Facts, FrontEffect, Parameter, Sites


def _advance(columns: EventColumns, values: Floats) -> Floats:
    return np.asarray(values[0] * np.nan_to_num(columns.deposit_length))


def _lacking(columns: EventColumns, _sites: Sites) -> str | None:
    known = columns.deposit_length[np.isfinite(columns.deposit_length)]
    return None if len(known) >= 10 else "fewer than 10 events have a deposit length"


def _build(_facts: Facts) -> FrontEffect:
    share = Parameter("share", "of the deposit length", 0.0, 0.5, 0.5, 0.0, 1.5)
    return FrontEffect("leading-edge", (share,), advance=_advance)


DEFINITION = Definition(
    key="leading-edge",
    meaning="What is written down is where the front came to lie, while the block is the centre "
    "of mass. The front is ahead by a share of the deposit's length (about a half).",
    needs="deposit length",
    build=_build,
    lacking=_lacking,
    event_columns=True,
    reads="deposit_length_m",
    order=160,
)
