"""The coordinates of a model, from its specification, its effects and what was measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.effects.effect import Effect, GroupEffect, Parameter
from avahazard.inference.model.given_prior import with_given
from avahazard.inference.model.laws import law
from avahazard.inference.model.layout import (
    LEAST_WRONG,
    MIN_SPREAD,
    MOST_WRONG,
    TRACK_GRID,
    TRACK_SCATTER,
    TRACK_SLOT,
    WRONG_SHARE,
    Grids,
    Layout,
    Slot,
    least_scatter,
    regridded,
    scatter_centre,
)
from avahazard.inference.model.specification import Specification


def build_layout(
    specification: Specification,
    effects: tuple[Effect, ...],
    grids: Grids,
    *,
    speeds: bool,
) -> Layout:
    """The coordinates of a model; `grids` replaces grids, and so ranges, by name.

    With measured `speeds` friction scatters along tracks.
    """
    chosen = law(specification.law)
    # A prior is that of one law; a model of another law has that law's own.
    told = specification.prior
    prior = told if told is not None and told.law == chosen.name else None
    mean, sd = (chosen.prior_mean, chosen.prior_sd) if prior is None else (prior.mean, prior.sd)
    slots = [
        Slot(name, "", float(m), float(s))
        for name, m, s in zip(chosen.coordinates, mean, sd, strict=True)
    ]
    log_scatter = specification.distribution == "lognormal"
    centre = scatter_centre(log_scatter)
    scatter = len(slots)
    slots.append(
        Slot(
            "log sigma",
            "",
            float(np.log(centre)),
            1.0,
            float(np.log(least_scatter(log_scatter))),
            2.0,
        )
    )
    slope = None
    if specification.scatter == "volume":
        slope = len(slots)
        per_volume = 1.0 / specification.reference_volume_m3
        slots.append(Slot("sigma_n", "", 0.0, 1.0, scale=per_volume))
    places: dict[str, slice] = {}
    spreads: dict[str, int] = {}
    for effect in effects:
        if isinstance(effect, GroupEffect):
            spreads[effect.key] = len(slots)
            slots.append(_spread_slot(effect.parameters[0]))
            continue
        places[effect.key] = slice(len(slots), len(slots) + len(effect.parameters))
        slots += [_slot(effect, p) for p in effect.parameters]
    wrong_share = None
    if specification.tails == "student":
        wrong_share = len(slots)
        bounds = float(np.log(LEAST_WRONG)), float(np.log(MOST_WRONG))
        slots.append(Slot("log wrong share", "", float(np.log(WRONG_SHARE)), 1.0, *bounds))
    tables = tuple(k for k, s in enumerate(slots) if s.grid)
    track_scatter = None
    if speeds:
        track_scatter = len(slots)
        slots.append(
            Slot(
                TRACK_SLOT,
                "",
                float(np.log(TRACK_SCATTER)),
                1.0,
                TRACK_GRID[0],
                TRACK_GRID[-1],
                TRACK_GRID,
            )
        )
    layout = Layout(
        law=chosen,
        slots=tuple(slots),
        scatter=scatter,
        scatter_slope=slope,
        reference_volume=specification.reference_volume_m3,
        spreads=spreads,
        wrong_share=wrong_share,
        track_scatter=track_scatter,
        places=places,
        tables=tables,
        log_scatter=log_scatter,
        law_correlation=None if prior is None else prior.correlation,
    )
    layout = replace(layout, slots=with_given(layout, specification.given))
    return regridded(layout, grids)


def _spread_slot(p: Parameter) -> Slot:
    """A spread's slot goes by the parameter's own name, under which draws are stored."""
    scale = p.prior_sd
    return Slot(p.name, p.unit, 0.0, 1.0, MIN_SPREAD / scale, 10.0, scale=scale)


def _slot(effect: Effect, p: Parameter) -> Slot:
    name = effect.key if p.name == "" else f"{effect.key}.{p.name}"
    scale = p.prior_sd
    return Slot(
        name,
        p.unit,
        p.prior_mean / scale,
        1.0,
        p.low / scale,
        p.high / scale,
        tuple(g / scale for g in p.grid),
        p.neutral / scale,
        scale,
        p.neutral,
    )
