"""How large an effect these data would have shown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import stats

from avahazard.criticism.diagnosis.friction_variance import friction_variance
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.verdict import MARGIN
from avahazard.inference.model.observations import LEFT

TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""


class Detectable(NamedTuple):
    """The smallest effect that would have been seen with 80 % power.

    As rms of log friction, in metres (H/L where that is recorded), and as the share that it would
    be of all that scatters log friction, errors of the records included: over 1 where even more
    than that could be missed.
    """

    log_friction: float
    metres: float
    share: float


def detectable(base: Refit, critical_gain: float) -> Detectable:
    """The smallest effect that would have been seen with 80 % power.

    A shift of rms δ in log friction has, on n events of total variance s², a gain with
    non-centrality n δ²/s²; the gain must pass `critical_gain`, and be worth `MARGIN` after the
    price of one more parameter.
    """
    observations = base.posterior.observations
    stopped = observations.kind != LEFT
    variance = friction_variance(base)
    information = float(np.sum(1.0 / variance.total[stopped]))
    price = 0.5 * float(np.log1p(information * TYPICAL_SD**2))
    gain = max(critical_gain, MARGIN + price)
    shift = (np.sqrt(2.0 * gain) + float(stats.norm.ppf(0.8))) / np.sqrt(information)
    # The record's spread in metres against that in log friction tells metres per unit.
    sigma = observations.recorded_sigma(base.posterior.record_sigma(base.mode.u))
    ratio = sigma[stopped] / np.sqrt(np.maximum(variance.record[stopped], 1e-8))
    return Detectable(
        log_friction=float(shift),
        metres=float(shift * np.median(ratio)),
        share=float(shift**2 * information / np.count_nonzero(stopped)),
    )
