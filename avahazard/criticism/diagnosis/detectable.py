"""How large an effect these data would have shown."""

from __future__ import annotations

import numpy as np
from scipy import stats

from avahazard.criticism.diagnosis.friction_variance import friction_variance
from avahazard.criticism.diagnosis.refits import Refit
from avahazard.criticism.diagnosis.verdict import MARGIN
from avahazard.inference.model.observations import LEFT

TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""


def detectable(base: Refit, critical_gain: float) -> tuple[float, float]:
    """The smallest effect that would have been seen with 80 % power: rms log friction, metres.

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
    return float(shift), float(shift * np.median(ratio))
