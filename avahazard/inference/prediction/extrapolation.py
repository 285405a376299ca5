"""How far a volume lies beyond what a model was calibrated on, and where its friction then goes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.seeds import generator
from avahazard.notes import Note

LEAST_FRICTION, MOST_FRICTION = 0.1, 1.5
"""What Coulomb friction of avalanches may be.

Extreme snow avalanches are given no less than 0.155 (Salm, Burkard & Gubler 1990), and H/L of the
largest rock avalanches comes down to 0.1 (Scheidegger 1973). Slabs hardly hold on slopes of over
55 degrees (McClung & Schaerer 2006): snow that slides there has less than their tangent, 1.4.
"""
RARE = 0.01
"""A share of draws outside that is not worth a word."""
BEYOND = 1.001
"""A volume this many times the largest recorded is beyond it."""


@dataclass(frozen=True, slots=True)
class Extrapolation:
    """A volume (m3) on a path against the records of a calibration, and the friction there.

    `largest_of_path_m3`, `largest_m3`: the largest recorded volumes, None without any.
    `too_low`, `too_high` are shares of the draws of friction outside what physics allows,
    `median` is theirs.
    """

    path_id: str | None
    volume_m3: float
    largest_of_path_m3: float | None
    largest_m3: float | None
    median: float
    too_low: float
    too_high: float

    @property
    def times_path(self) -> float | None:
        """The volume over the largest of the path; None where it is not beyond it."""
        return _times(self.volume_m3, self.largest_of_path_m3)

    @property
    def times_all(self) -> float | None:
        """The volume over the largest of all paths; None where it is not beyond it."""
        return _times(self.volume_m3, self.largest_m3)

    def notes(self, *of: str) -> list[Note]:
        """What a reader must know where something is extrapolated; `of` is the path, if said."""
        values = {
            "volume": _rounded(self.volume_m3, 3),
            "times_path": _times_rounded(self.times_path),
            "largest_of_path": _rounded(self.largest_of_path_m3, 3),
            "times": _times_rounded(self.times_all),
            "largest": _rounded(self.largest_m3, 3),
        }
        notes = []
        if self.times_path is not None:
            key = "beyond_path" if self.times_all is None else "beyond_both"
            notes.append(Note(key, of, **values))
        elif self.times_all is not None:
            notes.append(Note("beyond_all", of, **values))
        for key, share, limit in (
            ("friction_too_low", self.too_low, LEAST_FRICTION),
            ("friction_too_high", self.too_high, MOST_FRICTION),
        ):
            if share > RARE:
                drawn = {"share": share, "limit": limit, "median": self.median}
                notes.append(Note(key, of, volume=values["volume"], **drawn))
        return notes


def extrapolation(model: FittedModel, path_id: str | None, volume_m3: float) -> Extrapolation:
    """Hold a volume on a path (None: of none) against the events that `model` was fitted on.

    Friction is drawn from the posterior, with its scatter and the path's offset; effects that
    look at columns of the event are at their reference.
    """
    columns = model.columns
    volume = np.exp(columns.log_volume)
    mine = np.zeros(len(volume), dtype=np.bool_)
    if path_id in columns.paths:
        mine = columns.path_index == columns.paths.index(path_id)
    drawn = _frictions(model, path_id, volume_m3)
    return Extrapolation(
        path_id=path_id,
        volume_m3=float(volume_m3),
        largest_of_path_m3=_largest(volume[mine]),
        largest_m3=_largest(volume),
        median=float(np.median(drawn)),
        too_low=float(np.mean(drawn < LEAST_FRICTION)),
        too_high=float(np.mean(drawn > MOST_FRICTION)),
    )


def _frictions(model: FittedModel, path_id: str | None, volume_m3: float) -> Floats:
    """Draws of friction `[n_draws]`; of its middle alone where the stop scatters, not friction."""
    friction, u = model.friction, model.draws
    location, scatter = friction.location_and_scatter(u, np.array([[volume_m3]]))
    rng = generator(0, "extrapolation")
    tau = model.layout.spread_values(u)
    shift = np.zeros(len(u))
    for g, lasting in enumerate(friction.lasting):
        known = model.offsets.get(path_id or "") if lasting else None
        shift = shift + (tau[:, g] * rng.standard_normal(len(u)) if known is None else known)
    middle = friction.shifted(location[:, 0, 0], shift)
    if model.sigma_m is not None:
        return np.exp(middle) if model.layout.log_scatter else middle
    return friction.draw(middle, scatter[:, 0, 0], rng)


def _largest(volume: Floats) -> float | None:
    known = volume[np.isfinite(volume)]
    return float(known.max()) if len(known) else None


def _times_rounded(times: float | None) -> float:
    """Two digits, as 1.4 or 140; three below 1.1, and no less than 1.01: it is never once."""
    if times is None:
        return 0.0
    return _rounded(max(times, 1.01), 3 if times < 1.1 else 2)


def _rounded(value: float | None, digits: int) -> float:
    return float(f"{value or 0.0:.{digits}g}")


def _times(volume: float, largest: float | None) -> float | None:
    if largest is None or volume <= BEYOND * largest:
        return None
    return volume / largest
