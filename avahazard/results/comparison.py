"""Models against the measurements, every one and its error, and predictions of new events."""

from dataclasses import field
from typing import Self

from avahazard.notes import Note
from avahazard.results.base import ABSENT, Result, Rows


class RunoutScores(Result):
    """Predicted against recorded runouts, in metres of the record's own coordinate.

    `bias_m` is predicted minus recorded; the noise floors are what errors of the records, of their
    volumes and releases alone leave; `pit_histogram` counts ranks of records in ten equal bins.
    """

    n: int
    rmse_m: float
    bias_m: float
    crps_m: float
    coverage_50: float
    coverage_90: float
    noise_floor_m: float
    noise_floor_crps_m: float
    pit_histogram: tuple[int, ...]


class SpeedScores(Result):
    """Predicted against measured speeds, m/s, over all places."""

    n: int
    rmse_m_s: float
    bias_m_s: float
    crps_m_s: float
    coverage_50: float
    coverage_90: float
    noise_floor_m_s: float


class PredictedRecords(Result):
    """Scores of predicted records, those of `runout_x` in x for the events with a profile."""

    runout: RunoutScores
    speed: SpeedScores | None
    elpd_loo: float | None
    elpd_loo_se: float | None
    runout_x: RunoutScores | None = None


class Scores(PredictedRecords, kw_only=True):
    """In-sample scores; `elpd_loo` (nats) leaves each record out.

    `pareto_k_bad` counts events whose leave-one-out weights are not to be trusted.
    """

    pareto_k_bad: int
    pareto_k_refitted: int


class GroupError(Result):
    """The error (mean CRPS, m) of the events of one held-out path or fold."""

    group: str
    n: int
    crps_m: float


class HeldOutScores(PredictedRecords, kw_only=True):
    """Scores held-out `by` path or fold; `runout.crps_m` is the error of the model.

    Each of `n_fits` fits is without one group, or, of many paths, a part of them. `parent_crps_m`
    is the error of the model's parent on the same groups, where that was compared on others.
    """

    by: str
    groups: Rows[GroupError] = field(default_factory=Rows)
    n_fits: int | None = None
    parent_crps_m: float | None = None

    def alike(self, other: Self) -> bool:
        """Whether both leave out the same groups."""
        ours, theirs = ([(row.group, row.n) for row in one.groups] for one in (self, other))
        return self.by == other.by and ours == theirs


class BudgetPart(Result):
    """Root mean square (m, in the coordinate of the records) of what one source does.

    Squares add up to that of the error: of the model, or of the first model that it descends
    from, whose error the named effects have explained.
    """

    source: str
    rms_m: float


class EventBudget(Result):
    """The standard deviations (m) to be expected of one event, by source, and its error.

    `profile_m`, what the profile's points do, is no source of its own: see `Comparison`.
    """

    event_id: str
    record_m: float
    volume_m: float
    scatter_m: float
    parameters_m: float
    error_m: float
    release_m: float = 0.0
    profile_m: float = 0.0


class Failure(Result):
    """One level of an axis along which the model may fail: its bias.

    `p_value`: whether chance could do that, corrected for all levels.
    """

    axis: str
    level: Note
    n: int
    bias_m: float
    p_value: float


class SpeedMisfit(Result):
    """Misfit of speeds in one level of an axis, m/s; `p_value` as that of a `Failure`, by track."""

    axis: str
    level: Note
    n: int
    bias_m_s: float
    rmse_m_s: float
    p_value: float | None = None


class MeasuredForce(Result):
    """What resisted an avalanche over a stretch of its track, g sinθ - u du/dξ, in m/s2."""

    event_id: str
    x_m: float
    speed_m_s: float
    force_m_s2: float
    sd_m_s2: float
    slope_deg: float


class Comparison(Result):
    """A model against the measurements: scores, held-out scores, and where it fails.

    `profile_m` is the root mean square (m) of what the error of the profiles' points does to the
    predicted stops, None without profiles. It is in `scatter` and `unexplained` already, as far
    as the calibration on the same points has not taken it into the friction.
    """

    model: str
    coordinate: str
    scores: Scores
    held_out: HeldOutScores
    where_it_fails: Rows[Failure]
    speed_misfit: Rows[SpeedMisfit] | None
    measured_force: Rows[MeasuredForce] | None
    budget: Rows[BudgetPart] = field(default_factory=Rows)
    budget_by_event: Rows[EventBudget] = field(default_factory=Rows)
    profile_m: float | None = None
    notes: tuple[Note, ...] = ()
    next: Note | None = field(default=None, metadata=ABSENT)


class PredictedEvent(Result):
    """Where one event will stop: elevation (m), or runout length without a profile."""

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


class PredictionScores(PredictedRecords, kw_only=True):
    """Predictions against the runouts of the file, in the `coordinate` of the records."""

    coordinate: str


class Prediction(Result):
    """All events of a file; `scores` over those that have a runout, None where none has."""

    events: Rows[PredictedEvent]
    scores: PredictionScores | None
    notes: tuple[Note, ...] = ()


class Standing(Result):
    """The scores of a model by which it is ranked; errors in metres, `elpd` in nats.

    The error of the model is `held_out_crps_m`, in the coordinate of the records, or
    `held_out_crps_x_m`, in x where there are profiles.
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


class ErrorFall(Result):
    """By how much (m) the error of held-out records falls, with its 90 % interval."""

    mean_m: float
    q05_m: float
    q95_m: float


CLEAR_NATS, SMALL_RISE, LARGE_RISE = 3.0, 0.02, 0.05
"""Rise of the elpd (nats) for which a child may be kept in spite of a rise of its CRPS, the share
of this that is small in any case, and the one that is large even if it may be chance."""


class BeforeAndAfter(Result):
    """A parent's scores and its child's; `fall` is None where held-out groups are too few."""

    before: Standing | None
    after: Standing
    held_out_by: str
    coordinate: str = "elevation"
    fall: ErrorFall | None = None

    @property
    def gain(self) -> float | None:
        """By how much (nats) the elpd of held-out records rises."""
        before = None if self.before is None else self.before.held_out_elpd
        after = self.after.held_out_elpd
        return None if before is None or after is None else after - before

    @property
    def rises(self) -> bool:
        """Whether the held-out CRPS is larger than before."""
        before = self.before
        return before is not None and self.after.held_out_crps_m > before.held_out_crps_m

    @property
    def worse(self) -> bool:
        """Whether the child is not to be kept: its error rises.

        It is kept all the same where the rise is small, or not large and within chance, and the log
        score, in which speeds and widths count as well, rises clearly.
        """
        if self.before is None or not self.rises:
            return False
        before, after = self.before.held_out_crps_m, self.after.held_out_crps_m
        within = self.fall is not None and self.fall.q95_m > 0.0
        slight = after < (1.0 + (LARGE_RISE if within else SMALL_RISE)) * before
        return not (slight and (self.gain or 0.0) > CLEAR_NATS)


class LadderEntry(Result):
    """One model on the ladder; its scores are as `Standing`, None where it was never compared."""

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


class Ladder(Result):
    """All models, oldest first, with notes and the step to do now with the best of them."""

    rows: Rows[LadderEntry]
    notes: tuple[Note, ...] = ()
    next: Note | None = field(default=None, metadata=ABSENT)
