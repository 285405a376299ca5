"""Events without a profile whose friction follows a column, or nothing: quick to diagnose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.records.collection import Event, Records

ROCKS = ("gneiss", "lime", "slate")


def lengths(n: int = 90, slope: float = 0.0, seed: int = 1, n_columns: int = 3) -> Records:
    """Runout lengths of H/μ, log μ = log 0.5 - 0.1 log(V/1e5) + `slope` x column_1 + scatter.

    `column_k` are standard normal, `rock` is one of three.
    """
    rng = np.random.default_rng(seed)
    volume = 1e5 * np.exp(rng.standard_normal(n))
    columns = rng.standard_normal((n, n_columns))
    log_mu = np.log(0.5) - 0.1 * np.log(volume / 1e5) + slope * columns[:, 0]
    mu = np.exp(log_mu + 0.15 * rng.standard_normal(n))
    error = 20.0 * rng.standard_normal(n)
    rock = rng.choice(ROCKS, n)
    return Records(
        events=tuple(
            Event(
                f"e{i}",
                fall_height_m=1000.0,
                runout_length_m=float(1000.0 / mu[i] + error[i]),
                runout_sigma_m=20.0,
                volume_m3=float(volume[i]),
                volume_rel_sigma=0.1,
                covariates={
                    "rock": str(rock[i]),
                    **{f"column_{k + 1}": float(v) for k, v in enumerate(columns[i])},
                },
            )
            for i in range(n)
        )
    )


def shifted(records: Records, columns: dict[str, np.ndarray], log_friction: np.ndarray) -> Records:
    """The records with these columns instead of theirs, and log friction this much more."""
    return replace(
        records,
        events=tuple(
            replace(
                e,
                runout_length_m=(e.runout_length_m or 0.0) * float(np.exp(-log_friction[i])),
                covariates={name: values[i].item() for name, values in columns.items()},
            )
            for i, e in enumerate(records.events)
        ),
    )


def as_csv(records: Records) -> str:
    """The text of events.csv."""
    names = list(records.events[0].covariates)
    head = ["event_id", "fall_height_m", "runout_length_m", "runout_sigma_m", "volume_m3"]
    rows = [
        [e.event_id, e.fall_height_m, e.runout_length_m, e.runout_sigma_m, e.volume_m3]
        + [e.covariates[name] for name in names]
        for e in records.events
    ]
    return "\n".join(",".join(str(v) for v in row) for row in [head + names, *rows]) + "\n"
