"""One run of the block by a stored model."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.workflow.one_path import find_path, find_profile
from avahazard.workflow.runout import run_site
from avahazard.workflow.stored_model import load_stored

Floats = NDArray[np.float64]


def run_model(
    database: str, path_id: str, name: str, *, volume_m3: float | None, mu: float | None = None
) -> dict[str, Any]:
    """Run the block down a path with the effects of model `name` (docs/results.md).

    The friction is the posterior median of that of an event of `volume_m3`, or `mu` where that
    is given; effects on the motion are at their posterior means. Besides the keys of `run_path`:
    `model`, `volume_m3`, `mu_from` and `notes`.

    Raises:
        AvahazardError: there is no such model, path or profile, or neither `mu` nor a volume
            over 0 is given.
    """
    if mu is None and not (volume_m3 is not None and np.isfinite(volume_m3) and volume_m3 > 0.0):
        raise AvahazardError("The volume must be a number over 0.", "Give it in m3: --volume 20000")
    stored = load_stored(database, name)
    find_profile(stored.records, find_path(stored.records, path_id))
    # One event of that volume, from the path's own release.
    model = stored.on([Event("", path_id=path_id, volume_m3=volume_m3)])
    source = "given"
    if mu is None:
        assert volume_m3 is not None
        mu = float(model.median_friction(np.array([volume_m3]))[0])
        source = "posterior median"
    site = model.observations.sites[0]
    values = model.posterior.layout.effect_values(model.draws.mean(axis=0))
    resistance = model.posterior.resistance(site, values)
    notes = []
    if stored.records_changed:
        notes.append(f"the records have changed since {name} was calibrated.")
    return {
        "path_id": path_id,
        "model": name,
        "volume_m3": volume_m3,
        "mu_from": source,
        **run_site(site, mu, resistance),
        "notes": notes,
    }
