"""What people do today on the same world: the best BIC, or the best column of a regression."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from avahazard.criticism.diagnosis.diagnose import Diagnosis
from avahazard.inference.fitting.mode import likely_friction
from avahazard.inference.model.observations import Observations

Floats = NDArray[np.float64]

SIGHT = "observation-limit"
NAMES = {
    "snow_type": "snow-type",
    "section": "path-section",
    "day_of_winter": "season",
    "release_elevation": "release-elevation",
    "deposit_length": "leading-edge",
    "path": "path-effect",
    "volume": "volume-law",
}
"""What a column stands for, in favour of the regression."""


def best_bic(found: Diagnosis) -> str | None:
    """The candidate with the best BIC, None where the model without any has it.

    Gains are those of the full refit where there is one, else of the quick fit. An unknown limit
    of sight counts a parameter for each path, which favours this rival.
    """
    observations = found.base.posterior.observations
    best, name = 0.0, None
    for c in found.candidates:
        gain = c.screened.gain
        if c.fit is not None:
            gain = c.fit.log_likelihood - found.base.log_likelihood
        entry = c.screened.definition
        effect = entry.build(entry.facts(observations.columns, observations.sites))
        k = max(1, len(effect.parameters)) + (len(observations.sites) if c.key == SIGHT else 0)
        score = 2.0 * gain - k * float(np.log(observations.n_events))
        if score > best:
            best, name = score, c.key
    for group in found.groups:
        score = 2.0 * group.gain - float(np.log(observations.n_events))
        if score > best:
            best, name = score, group.key
    return name


def regression(found: Diagnosis) -> str | None:
    """The column whose smooth (a cubic, or levels) best explains back-calculated friction.

    F test beside volume, Bonferroni's correction over the columns, level 0.05.
    """
    posterior = found.base.posterior
    observations = posterior.observations
    friction = np.log(likely_friction(posterior.nodes.at(found.base.mode.u), True))
    known = np.isfinite(friction)
    volume = np.exp(observations.volumes.mean)
    nothing = np.column_stack([np.ones(len(volume)), volume / volume.mean()])
    tested = {name: c for name, c in smooths(observations).items() if np.all(np.isfinite(c))}
    best, name = 0.05 / max(1, len(tested)), None
    for column, smooth in tested.items():
        p = _f_test(friction[known], nothing[known], smooth[known])
        if p < best:
            best, name = p, NAMES.get(column, f"covariate:{column}")
    return name


def smooths(observations: Observations) -> dict[str, Floats]:
    """Columns `[n_events, n]` of the cubic, or of the levels, of everything known."""
    columns = observations.columns
    numbers = {
        "year": columns.year,
        "day_of_winter": columns.day_of_winter,
        "release_elevation": columns.release_elevation,
        "deposit_length": np.log(columns.deposit_length),
        "volume": observations.volumes.mean,
        **columns.numbers,
    }
    texts = {
        "section": columns.section,
        "path": columns.path_index.astype(str),
        **columns.texts,
    }
    result = {}
    for name, values in numbers.items():
        z = (values - np.mean(values)) / max(float(np.std(values)), 1e-12)
        result[name] = np.column_stack([z, z**2, z**3])
    for name, values in texts.items():
        levels = np.unique(values)[1:]
        if len(levels):
            result[name] = np.column_stack([values == level for level in levels]).astype(float)
    return result


def _f_test(y: Floats, without: Floats, columns: Floats) -> float:
    with_ = np.column_stack([without, columns])

    def left(x: Floats) -> tuple[float, int]:
        fitted, _, rank, _ = np.linalg.lstsq(x, y, rcond=None)
        return float(np.sum((y - x @ fitted) ** 2)), int(rank)

    (a, p), (b, q) = left(without), left(with_)
    if q == p:
        return 1.0
    n = len(y)
    return float(stats.f.sf((a - b) / (q - p) / (b / (n - q)), q - p, n - q))
