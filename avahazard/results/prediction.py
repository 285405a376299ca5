"""Predictive distributions of new events."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.notes import Note
from avahazard.results.base import Result, Rows
from avahazard.results.comparison import RunoutScores, SpeedScores


@dataclass(frozen=True, slots=True)
class PredictedEvent(Result):
    """Where one event will stop: elevation (m), or runout length without a profile.

    `notes` are what a reader must know of the model and of this event's volume.
    """

    event_id: str
    path_id: str | None
    coordinate: str
    mean_m: float
    sd_m: float
    q05_m: float
    q50_m: float
    q95_m: float
    p_left_profile: float
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True, slots=True)
class PredictionScores(Result):
    """Predictions against the runouts of the file; `elpd_loo` is their log density (nats).

    `runout` is in the `coordinate` of the records, `runout_x` in x where there are profiles.
    """

    runout: RunoutScores
    speed: SpeedScores | None
    elpd_loo: float | None
    elpd_loo_se: float | None
    coordinate: str
    runout_x: RunoutScores | None


@dataclass(frozen=True, slots=True)
class Prediction(Result):
    """All events of a file; `scores` over those that have a runout, None where none has.

    `notes` are those of all events, and on all of them, each once.
    """

    events: Rows[PredictedEvent]
    scores: PredictionScores | None
    notes: tuple[Note, ...] = ()
