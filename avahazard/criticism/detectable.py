"""How large an effect these data would have shown."""

from __future__ import annotations

import numpy as np
from scipy import stats

from avahazard.criticism.refits import Refit
from avahazard.criticism.verdict import MARGIN
from avahazard.inference.study import LEFT

TYPICAL_SD = 0.2
"""Prior sd of a typical effect on log friction."""


def detectable(base: Refit, critical_gain: float) -> tuple[float, float]:
    """The smallest effect that would have been seen with 80 % power: rms log friction, metres.

    A shift of rms δ in log friction has, on n events of total variance s², a gain with
    non-centrality n δ²/s²; the gain must pass `critical_gain`, and be worth `MARGIN` after the
    price of one more parameter.
    """
    posterior = base.posterior
    study = posterior.study
    _, scatter = posterior.location_and_scatter(base.mode.u)
    nodes = posterior.nodes_at(base.mode.u)
    mean = np.sum(nodes.place * nodes.weight, axis=1, keepdims=True)
    record_variance = np.sum(nodes.weight * (nodes.place - mean) ** 2, axis=1)
    stopped = study.kind != LEFT
    total = np.mean(scatter**2, axis=1) + np.where(stopped, record_variance, 0.0)
    information = float(np.sum(1.0 / total[stopped]))
    price = 0.5 * float(np.log1p(information * TYPICAL_SD**2))
    gain = max(critical_gain, MARGIN + price)
    shift = (np.sqrt(2.0 * gain) + float(stats.norm.ppf(0.8))) / np.sqrt(information)
    # The record's spread in metres against that in log friction tells metres per unit.
    ratio = study.sigma[stopped] / np.sqrt(np.maximum(record_variance[stopped], 1e-8))
    return float(shift), float(shift * np.median(ratio))
