"""What a calibration found, by whichever method."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.effects.effect import Facts
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.samplers.chains import Chains


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A model calibrated on observations.

    `chains` holds the parameters that people read, chain by chain; `n_events` were used, and
    `left_out` counts the others by the reason why the method cannot use them; `notes` are
    sentences for people.
    """

    model: FittedModel
    facts: dict[str, Facts]
    chains: Chains
    n_events: int
    left_out: dict[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
