"""What whoever reads a model must know of the volumes that it takes for true."""

from __future__ import annotations

import numpy as np

from avahazard.inference.model.laws import LAWS
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.message import message

ENDED = message(
    "{model} takes no true volume for larger than {largest} m3, as its records together tell: what "
    "is recorded above that counts as an error."
)
SHAPED = message(
    "{model} does not take true volumes for lognormal: its records together tell another shape of "
    "their spread within a path."
)


def volume_notes(model: FittedModel, name: str) -> tuple[str, ...]:
    """That its volumes are not taken for lognormal, where friction goes by volumes with errors."""
    volumes = model.observations.volumes
    if not LAWS[model.specification.law].uses_volume or not np.any(volumes.sd > 0.0):
        return ()
    if volumes.population.shape is not None:
        return (SHAPED.format(model=name),)
    if np.isinf(volumes.largest):
        return ()
    largest = float(f"{volumes.largest:.2g}")
    return (ENDED.format(model=name, largest=f"{largest:.0f}"),)
