"""What the page's switch and sliders need to know, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from avahazard.report.html.content import ReportContent, StateView
from avahazard.report.html.figure import script_json

DIGITS = 5


def switch_json(content: ReportContent) -> Markup:
    """Errors by state, sweeps, and for every path the tables F(μ) and μ(V)."""
    loop = content.loop
    states = (*loop.models, *loop.swept)
    shared: list[Any] = []
    tables = {state.key: _tables(state, shared) for state in states}
    value = {
        "own": loop.lineage[-1],
        "models": [state.key for state in loop.models],
        "states": {
            state.key: {
                "held_out_m": state.held_out_m,
                "crps_m": state.crps_m,
                "rmse_m": state.rmse_m,
                "tables": tables[state.key],
            }
            for state in states
        },
        "tables": shared,
        "sweeps": [
            {"effect": s.effect, "strengths": s.strengths, "keys": s.keys} for s in loop.sweeps
        ],
        "mu": loop.mu,
        "volumes": loop.volumes,
        "paths": {
            view.path.path_id: {"number": number, "profile": _profile(view.smooth)}
            for number, view in enumerate(content.paths, start=1)
            if view.smooth is not None
        },
    }
    return script_json(value, DIGITS)


def _tables(state: StateView, shared: list[Any]) -> dict[str, list[int]]:
    """By path the numbers of its tables F(μ) and μ(V) among the shared ones."""
    found: dict[str, list[int]] = {}
    for k, path in enumerate(state.path_ids):
        pair = []
        for table in (np.round(state.stops[k]).tolist(), np.round(state.friction[k], 4).tolist()):
            if table not in shared:
                shared.append(table)
            pair.append(shared.index(table))
        found[path] = pair
    return found


def _profile(smooth: Any) -> dict[str, Any]:
    x = np.linspace(smooth.x_min, smooth.x_max, 160)
    return {"x": np.round(x, 1), "y": np.round(smooth.height(x), 1)}
