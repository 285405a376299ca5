"""A model with one of its effects weaker and stronger, the rest fitted again each time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode_search import held_climb
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.prediction.fitted_model import FittedModel

STRENGTHS = (0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)
"""Shares of what an effect was fitted to; at 0 it is not there."""


def sweepable(model: FittedModel) -> tuple[str, ...]:
    """The effects of a model that have a strength: those that add parameters to it."""
    layout = model.posterior.layout
    return tuple(e.key for e in model.posterior.effects
                 if e.key in layout.places or e.key in layout.spreads)  # fmt: skip


def sweep(model: FittedModel, effect: str) -> Iterator[tuple[float, FittedModel]]:
    """The model at each strength of one effect; at strength 1 it is the model itself.

    The effect's parameters go from neutral through their draws; where it shapes the tables only
    the first of them, which is its amount. The other parameters are moved by as much as their
    most likely values move, and keep their spread, but for those that shape the tables: these
    stand at their mean, which spares runs of the block.
    """
    posterior = _on_whole_ranges(model.posterior)
    layout = posterior.layout
    moved = _slots(posterior, effect)
    neutral = np.nan_to_num([layout.slots[k].neutral for k in moved])
    middle = model.draws.mean(axis=0)
    held = list(_all_slots(posterior, effect))
    _, fitted = held_climb(posterior, middle, held, middle[held])
    for strength in STRENGTHS:
        if strength == 1.0:
            yield strength, model
            continue
        whole = middle.copy()
        whole[moved] = neutral + strength * (middle[moved] - neutral)
        corner = np.clip(whole, layout.low, layout.high)[held]
        _, found = held_climb(posterior, fitted, held, corner)
        draws = model.draws + (found - fitted)
        draws[:, held] = model.draws[:, held]
        draws[:, moved] = neutral + strength * (model.draws[:, moved] - neutral)
        shaping = list(layout.tables)
        draws[:, shaping] = draws[:, shaping].mean(axis=0)
        draws = np.clip(draws, layout.low, layout.high)
        changed = replace(model, friction=posterior.friction, likelihood=posterior, draws=draws)
        yield strength, replace(changed, offsets=_offsets(model, effect, strength))


def _on_whole_ranges(posterior: Posterior) -> Posterior:
    """The posterior on the star of the effects themselves, which reaches to where they are not."""
    return Posterior(posterior.observations, posterior.specification, posterior.effects)


def _all_slots(posterior: Posterior, effect: str) -> range:
    layout = posterior.layout
    if effect in layout.spreads:
        return range(layout.spreads[effect], layout.spreads[effect] + 1)
    place = layout.places[effect]
    return range(place.start, place.stop)


def _slots(posterior: Posterior, effect: str) -> list[int]:
    """The slots that a strength moves."""
    slots = list(_all_slots(posterior, effect))
    return slots[:1] if posterior.layout.slots[slots[0]].arm else slots


def _offsets(model: FittedModel, effect: str, strength: float) -> dict[str, Floats]:
    """The offsets of groups, those of the effect at that strength."""
    plan = model.posterior.plan
    grouping = list(model.posterior.layout.spreads)
    mine = {
        name
        for name, of in zip(plan.names, plan.of, strict=True)
        if plan and grouping[int(of)] == effect
    }
    return {n: strength * v if n in mine else v for n, v in model.offsets.items()}
