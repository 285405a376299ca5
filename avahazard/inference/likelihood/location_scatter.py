"""Where a model expects each event's friction to lie, and how far it scatters about."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.friction_scatter import volume_share, widened
from avahazard.inference.model.law_curves import bounded
from avahazard.inference.model.laws import Law
from avahazard.inference.model.layout import Layout
from avahazard.inference.model.volumes import VolumeNodes

Designs = Sequence[tuple[slice, Floats]]
"""The slots of each effect that shifts log friction, and its design `[n_events, n_parameters]`."""

MOST_LOG_SCATTER, LEAST_LOG_SCATTER = 4.0, -12.0


def line_covariate(law: Law, volumes: VolumeNodes) -> Floats | None:
    """What log μ is a line in at the nodes, `[n_events, n_volumes]`; None for other laws."""
    is_line = law.form == "line" and len(law.coordinates) == 2
    return law.covariate(volumes.volume) if is_line else None


def location_and_scatter(
    layout: Layout,
    designs: Designs,
    u: Floats,
    volume: Floats,
    own: Floats,
    covariate: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Location m (log μ, or μ for normal) and scatter σ, each `[..., n_events, n_volumes]`.

    At coordinates u `[..., n_slots]` and volumes (m3) `[n_events, n_volumes]`. `own`
    `[..., n_events]` is the variance of log friction that events have besides. `covariate`
    `[n_events, n_volumes]` is that of a law that is a line in it, where it is known
    (`line_covariate`): its logarithms are most of the work.
    """
    law = layout.law
    if covariate is None:
        flat = law.log_friction(u[..., : len(law.coordinates)], volume.ravel())
        location = flat.reshape(*u.shape[:-1], *volume.shape)
    else:
        with np.errstate(over="ignore"):  # bounded then
            location = bounded(u[..., 0, None, None] - u[..., 1, None, None] * covariate)
    for place, design in designs:
        location = location + (u[..., place] @ design.T)[..., None]
    log_scatter = u[..., layout.scatter, None, None]
    least = LEAST_LOG_SCATTER
    if layout.scatter_slope is not None:
        share = volume_share(volume, layout.reference_volume)
        log_scatter = log_scatter - u[..., layout.scatter_slope, None, None] * share
        # Where it falls with volume it stops at the least that the nodes can bear.
        least = layout.slots[layout.scatter].low
    if not layout.log_scatter:
        location = np.exp(location)
    scatter = np.exp(np.clip(log_scatter, least, MOST_LOG_SCATTER))
    scatter = np.broadcast_to(scatter, location.shape)
    if np.any(own):
        return location, widened(scatter, own[..., None], location, layout.log_scatter)
    return location, np.array(scatter)


def pulled(
    layout: Layout, designs: Designs, u: Floats, volume: Floats, pull: Floats, by_scatter: Floats
) -> Floats:
    """Derivatives `[n_slots]` by the coordinates u `[n_slots]` that move location and scatter.

    Of a sum over events whose derivatives in m and in log σ are `pull` and `by_scatter`, each
    `[n_events, n_volumes]`; 0 for other coordinates. Nothing else may scatter (`own` is 0).
    """
    slopes = np.zeros(len(u))
    n = len(layout.law.coordinates)
    if not layout.log_scatter:
        # m is μ itself.
        own = np.zeros(len(volume))
        pull = pull * location_and_scatter(layout, designs, u, volume, own)[0]
    by_law = layout.law.slopes(u[:n], volume.ravel())
    slopes[:n] = by_law @ pull.ravel()
    by_event = np.sum(pull, axis=1)
    for place, design in designs:
        slopes[place] = by_event @ design
    slopes[layout.scatter] = np.sum(by_scatter)
    if layout.scatter_slope is not None:
        share = volume_share(volume, layout.reference_volume)
        raw = u[layout.scatter] - u[layout.scatter_slope] * share
        free = (raw > layout.slots[layout.scatter].low) & (raw < MOST_LOG_SCATTER)
        slopes[layout.scatter] = np.sum(by_scatter[free])
        slopes[layout.scatter_slope] = -np.sum((by_scatter * share)[free])
    return slopes
