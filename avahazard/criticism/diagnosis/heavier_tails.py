"""Whether friction scatters with heavier tails than a model with normal ones knows.

Such a model takes a few wild or wrong records for scatter between all avalanches: its scatter is
too wide, and its law bends towards these records.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitting.mode import climb
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.prediction.fitted_model import FittedModel

ITERATIONS = 40


def heavier_tails(model: FittedModel) -> float | None:
    """What Student's tails gain (nats of log likelihood) over the normal ones of `model`.

    None where it has them, or for the paper's methods. Law, scatter and share of wrong records are
    at their best for either; effects and spreads of groups stay as calibrated, so that it is a
    little less than that of the models fitted in full, and takes a fraction of their time.
    """
    if not model.knows_errors or model.specification.tails != "normal":
        return None
    posterior = model.posterior
    grids = {slot.name: slot.grid for slot in posterior.layout.slots if slot.grid}
    student = Posterior(
        model.observations,
        replace(model.specification, tails="student"),
        posterior.effects,
        grids,
    )
    u = model.draws.mean(axis=0)
    known = dict(zip((slot.name for slot in posterior.layout.slots), u, strict=True))
    carried = np.array([known.get(slot.name, slot.mean) for slot in student.layout.slots])
    return _best(student, carried) - _best(posterior, u)


def _best(posterior: Posterior, u: Floats) -> float:
    """Log likelihood at the best law, scatter and share of wrong records from u on."""
    layout = posterior.layout
    free = [*range(len(layout.law.coordinates)), layout.scatter]
    if layout.wrong_share is not None:
        free.append(layout.wrong_share)
    start = np.clip(u, layout.low, layout.high)
    at, _ = climb(posterior, start, np.array(free), ITERATIONS)
    return float(posterior.log_likelihood(at))
