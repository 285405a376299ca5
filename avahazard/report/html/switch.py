"""What the page's switch and sliders need to know, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from avahazard.report.html.content import LoopView, ReportContent, StateView
from avahazard.report.html.figure import script_json
from avahazard.report.language import Language

DIGITS = 5


def switch_json(content: ReportContent) -> Markup:
    """Errors by state, sweeps, and for every path the tables F(μ) and μ(V)."""
    loop = content.loop
    states = (*loop.models, *loop.swept)
    shared: list[Any] = []
    tables = {state.key: _tables(state, shared) for state in states}
    value = {
        "own": loop.lineage[-1],
        "language": _language(content.language),
        "models": [state.key for state in loop.models],
        "states": {
            state.key: {
                "name": state_name(state.key, loop, content.language),
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


def state_name(key: str, loop: LoopView, language: Language) -> str:
    """A state as people read it: a model's name, or an effect and its strength."""
    for sweep in loop.sweeps:
        for known, strength in zip(sweep.keys, sweep.strengths, strict=True):
            if known == key and strength != 1.0:
                return f"{language.effect(sweep.effect)} × {language.number(f'{strength:g}')}"
    return key


def _language(language: Language) -> dict[str, Any]:
    """Signs of numbers, the words of the script, and those of Plotly's toolbar."""
    say = language.say
    return {
        "code": language.code,
        "decimal": language.decimal,
        "group": language.group,
        "separators": language.separators,
        "shown": say(
            "Shown: {model}. Error on all records of the calibration {crps} (CRPS; root mean "
            "square {rmse})."
        ),
        "shown_held_out": say(
            "Shown: {model}. Error on all records of the calibration {crps} (CRPS; root mean "
            "square {rmse}), on what was kept back {held_out}."
        ),
        "times": say("{strength} × that of {model}"),
        "stops": say("With μ = {friction} the block stops at x = {x} m, {y} m above sea level."),
        "leaves": say("With μ = {friction} the block runs past the end of the profile."),
        "toolbar": {
            "Download plot as a PNG": say("Download plot as a PNG"),
            "Download plot": say("Download plot as a PNG"),
            "Zoom": say("Zoom"),
            "Pan": say("Pan"),
            "Zoom in": say("Zoom in"),
            "Zoom out": say("Zoom out"),
            "Reset axes": say("Reset axes"),
        },
    }


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
