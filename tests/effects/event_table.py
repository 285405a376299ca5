"""Columns of events without a path."""

from __future__ import annotations

import numpy as np

from avahazard.effects.columns import EventColumns, build_columns
from avahazard.records.collection import Event


def event_table(**columns: list[float] | list[str]) -> EventColumns:
    """Events with these covariates, nan where one is missing; six events without any."""
    n = len(next(iter(columns.values()))) if columns else 6
    events = [
        Event(
            f"e{i}",
            fall_height_m=1000.0,
            runout_length_m=2000.0,
            covariates={
                key: values[i]
                for key, values in columns.items()
                if isinstance(values[i], str) or not np.isnan(values[i])
            },
        )
        for i in range(n)
    ]
    return build_columns(events, {}, np.full(n, np.nan))
