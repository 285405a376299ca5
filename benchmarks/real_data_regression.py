"""A plain regression of log(H/L) beside the product's models: least squares, Student's t."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Floats = NDArray[np.float64]

N_DRAWS = 2000


@dataclass(frozen=True, slots=True)
class Regression:
    """log(H/L) on log V, on dummies of `levels` and on cubics of `cubic`."""

    levels: tuple[str, ...] = ()
    cubic: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What it stands on."""
        return ", ".join(("log V", *self.levels, *(f"{column} (cubic)" for column in self.cubic)))


def regression_scores(learnt: Path, kept: Path, regression: Regression) -> dict[str, Any]:
    """Fit on `learnt`; CRPS (m of L), share in 90 % and log density of the rows of `kept`."""
    train, test = _rows(learnt), _rows(kept)
    x, names = _design(train, train, regression)
    y = _log_ratio(train)
    beta, *_ = np.linalg.lstsq(x, y, rcond=None)
    freedom = len(y) - x.shape[1]
    variance = float(np.sum((y - x @ beta) ** 2)) / freedom
    inverse = np.linalg.inv(x.T @ x)
    new, _ = _design(test, train, regression)
    scale = np.sqrt(variance * (1.0 + np.einsum("ij,jk,ik->i", new, inverse, new)))
    t = np.random.default_rng(0).standard_t(freedom, (len(test), N_DRAWS))
    height = np.array([float(row["fall_height_m"]) for row in test])
    length = np.array([float(row["runout_length_m"]) for row in test])
    draws = height[:, None] / np.exp((new @ beta)[:, None] + scale[:, None] * t)
    low, high = np.quantile(draws, [0.05, 0.95], axis=1)
    z = (_log_ratio(test) - new @ beta) / scale
    # The density of L, as the product gives it.
    density = stats.t.logpdf(z, freedom) - np.log(scale) - np.log(length)
    return {
        "crps_m": float(np.mean(_crps(draws, length))),
        "coverage_90": float(np.mean((low <= length) & (length <= high))),
        "elpd": float(np.sum(density)),
        "coefficients": {
            name: {"value": float(b), "se": float(np.sqrt(variance * inverse[k, k]))}
            for k, (name, b) in enumerate(zip(names, beta, strict=True))
        },
        "p_extra": _p_extra(train, regression, y),
    }


def _p_extra(train: list[dict[str, str]], regression: Regression, y: Floats) -> float | None:
    """F-test of all columns beside the volume; None where there are none."""
    if not (regression.levels or regression.cubic):
        return None

    def squares(which: Regression) -> tuple[float, int]:
        x, _ = _design(train, train, which)
        beta, *_ = np.linalg.lstsq(x, y, rcond=None)
        return float(np.sum((y - x @ beta) ** 2)), len(y) - x.shape[1]

    (small, less), (large, more) = squares(Regression()), squares(regression)
    return float(stats.f.sf((small - large) / (less - more) / (large / more), less - more, more))


def _design(
    rows: list[dict[str, str]], train: list[dict[str, str]], regression: Regression
) -> tuple[Floats, list[str]]:
    columns, names = [np.ones(len(rows))], ["1"]
    volume = np.log([float(row["volume_m3"]) for row in rows])
    centre = np.mean(np.log([float(row["volume_m3"]) for row in train]))
    columns.append(volume - centre)
    names.append("log V")
    for column in regression.levels:
        for level in sorted({row[column] for row in train})[1:]:
            columns.append(np.array([float(row[column] == level) for row in rows]))
            names.append(f"{column} {level}")
    for column in regression.cubic:
        known = np.array([float(row[column]) for row in train])
        value = (np.array([float(row[column]) for row in rows]) - known.mean()) / known.std()
        for power in (1, 2, 3):
            columns.append(value**power)
            names.append(f"{column}^{power}")
    return np.column_stack(columns), names


def _rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as lines:
        return [row for row in csv.DictReader(lines) if row["volume_m3"]]


def _log_ratio(rows: list[dict[str, str]]) -> Floats:
    return np.log([float(row["fall_height_m"]) / float(row["runout_length_m"]) for row in rows])


def _crps(draws: Floats, observed: Floats) -> Floats:
    """CRPS of samples `[n, n_draws]` by their order statistics."""
    ordered = np.sort(draws, axis=1)
    n = ordered.shape[1]
    weight = (2 * np.arange(1, n + 1) - n - 1) / n**2
    return np.abs(draws - observed[:, None]).mean(axis=1) - ordered @ weight
