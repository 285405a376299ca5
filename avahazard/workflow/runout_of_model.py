"""One run of the block by a stored model."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import resistance_of
from avahazard.inference.model.observations import build_observations
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.event import Event
from avahazard.workflow.one_path import find_path, find_profile
from avahazard.workflow.runout import run_site
from avahazard.workflow.stored_model import (
    StoredFit,
    coordinates_for,
    load_stored,
    posterior_for,
    records_changed,
    training_records,
)

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
    stored, records = load_stored(database, name)
    find_profile(records, find_path(records, path_id))
    posterior = _one_event(stored, records, path_id, volume_m3)
    u = coordinates_for(stored, posterior)
    source = "given"
    if mu is None:
        assert volume_m3 is not None
        mu = float(median_friction(stored, posterior, u, np.array([volume_m3]))[0])
        source = "posterior median"
    site = posterior.observations.sites[0]
    resistance = resistance_of(
        site,
        posterior.effects,
        posterior.layout.effect_values(u.mean(axis=0)),
        float(stored.specification.centrifugal),
    )
    notes = []
    if records_changed(stored, records):
        notes.append(f"the records have changed since {name} was calibrated.")
    return {
        "path_id": path_id,
        "model": name,
        "volume_m3": volume_m3,
        "mu_from": source,
        **run_site(site, mu, resistance),
        "notes": notes,
    }


def _one_event(
    stored: StoredFit, records: Records, path_id: str, volume_m3: float | None
) -> Posterior:
    """The model over one event of that volume on the path, from the path's own release."""
    event = Event("", path_id=path_id, volume_m3=volume_m3)
    one = Records(records.paths, records.profiles, (event,))
    prior = build_observations(training_records(stored, records))
    return posterior_for(stored, one, prior)[1]


def median_friction(stored: StoredFit, posterior: Posterior, u: Floats, volume: Floats) -> Floats:
    """Posterior median `[n_events]` of the median friction of the events of `posterior`.

    `volume` (m3) `[n_events]` is exact; `u` are draws of the coordinates `[n_draws, n_slots]`.
    """
    median = np.array(
        [posterior.location_and_scatter(draw, volume[:, None])[0][:, 0] for draw in u]
    )
    if stored.specification.distribution == "lognormal":
        median = np.exp(median)
    columns = posterior.observations.columns
    for k, path_id in enumerate(columns.paths):
        if path_id in stored.offsets:
            mine = columns.path_index == k
            median[:, mine] *= np.exp(stored.offsets[path_id])[:, None]
    return np.asarray(np.median(median, axis=0))
