"""Every model and its error."""

from __future__ import annotations

from dataclasses import dataclass, field

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows


@dataclass(frozen=True, slots=True)
class Standing(Result):
    """The scores of a model by which it is ranked; errors in metres, `elpd` in nats.

    What is `held_out` was predicted by fits without the event's group (its path, or a fold);
    `held_out_crps_m` is the error of the model, in the coordinate of the records,
    `held_out_crps_x_m` the same in x where there are profiles.
    """

    rmse_m: float
    crps_m: float
    held_out_rmse_m: float
    held_out_crps_m: float
    held_out_elpd: float | None
    elpd_loo: float | None
    elpd_loo_se: float | None
    coverage_90: float
    speed_rmse_m_s: float | None
    noise_floor_m: float
    noise_floor_crps_m: float
    held_out_crps_x_m: float | None = None


@dataclass(frozen=True, slots=True)
class ErrorFall(Result):
    """By how much (m) the error of held-out records falls, with its 90 % interval."""

    mean_m: float
    q05_m: float
    q95_m: float


@dataclass(frozen=True, slots=True)
class BeforeAndAfter(Result):
    """A parent's scores and its child's, beside what errors of the records alone leave.

    `fall` is that of the error, None where the groups held out are too few.
    """

    before: Standing | None
    after: Standing
    held_out_by: str
    noise_floor_m: float
    noise_floor_crps_m: float
    coordinate: str = "elevation"
    fall: ErrorFall | None = None


@dataclass(frozen=True, slots=True)
class Rung(Result):
    """One model on the ladder, with what it has that its parent has not.

    Scores are as `Standing`, None where it was never compared. `notes` are on this model.
    """

    model: str
    parent: str | None
    added: tuple[str, ...]
    rmse_m: float | None
    crps_m: float | None
    held_out_crps_m: float | None
    elpd_loo: float | None
    elpd_loo_se: float | None
    coverage_90: float | None
    speed_rmse_m_s: float | None
    noise_floor_m: float | None
    noise_floor_crps_m: float | None
    held_out_crps_x_m: float | None = None
    coordinate: str | None = None
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True, slots=True)
class Ladder(Result):
    """All models, oldest first, with notes and the step to do now with the best of them."""

    rows: Rows[Rung]
    notes: tuple[Note, ...] = ()
    next: Note | None = field(default=None, metadata=ABSENT)
