"""The records to be expected, and their scores.

They are stops drawn with the error of the record; scores are in its coordinate, or along the path.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avahazard.arrays import Bools, Floats
from avahazard.criticism.scoring.speed_misfit import MatchedSpeeds
from avahazard.effects.effect import LimitEffect, RecordErrorEffect, of_kind
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import raised_by
from avahazard.inference.model.observations import ELEVATION, LEFT, LENGTH, PLACE, Observations
from avahazard.inference.prediction import predict_stops
from avahazard.inference.seeds import generator
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.comparison import RunoutScores, SpeedScores

SPARE = 4
"""Draws for each one that is needed, where some would not be seen."""
FEWEST_SEEN = 20


class ExpectedRecords(NamedTuple):
    """Records `observed` `[n_events]` (m) and `draws` `[n_events, n_draws]` of what they might be.

    Both are in the coordinate of each record (elevation, x, runout length, H/L); `sigma`
    `[n_events]` is its measurement error. A runout beyond the profile, in the records or in the
    draws (`left` `[n_events, n_draws]`), counts as reaching the profile's end. `x` `[n_events,
    n_draws]` is the place of the stops, nan without a profile. `sign` `[n_events]` is -1 where an x
    or a length stands among elevations, so that errors of either point the same way.
    """

    observed: Floats
    sigma: Floats
    draws: Floats
    left: Bools
    x: Floats
    sign: Floats

    @property
    def error(self) -> Floats:
        """Predicted mean minus record `[n_events]` (m), the other way round where `sign` is -1."""
        return np.asarray(self.sign * (self.draws.mean(axis=1) - self.observed))


def expected_records(model: FittedModel, n_draws: int, rng: np.random.Generator) -> ExpectedRecords:
    """Draw records of every event; on paths with a detection limit, only draws that are seen."""
    observations, posterior = model.observations, model.posterior
    limited = bool(np.any(np.isfinite(_limits(posterior, model.draws[:1]))))
    n_stops = SPARE * n_draws if limited else n_draws
    stops = predict_stops(model, n_stops, rng, release_off=True)
    end = profile_end(observations)[:, None]
    noise = rng.standard_normal(stops.record.shape)
    noise *= observations.recorded_sigma(stops.sigma.T).T
    draws = observations.as_recorded(stops.record) + noise
    np.copyto(draws, end, where=stops.left)
    left, x = stops.left, stops.x
    if limited:
        first, place = np.unique(model.thinned(n_stops), return_inverse=True)
        limit = _limits(posterior, model.draws[first])[:, place]
        # A declared limit is of places, an estimated one of records.
        declared = np.isfinite(observations.limit)[:, None]
        values = posterior.layout.effect_values(np.median(model.draws, axis=0))
        raised = raised_by(observations, posterior.effects, values)[:, None]
        height = stops.elevation + np.where(declared, -raised, noise)
        excess = np.where(stops.left, -np.inf, height - limit)
        kept = _seen_first(np.nan_to_num(excess, nan=-np.inf, neginf=-np.inf), n_draws, rng)
        rows = np.arange(observations.n_events)[:, None]
        # A draw that came nearest without being seen stands for one that just was.
        short = np.maximum(excess[rows, kept], 0.0)
        in_elevation = (observations.kind == ELEVATION)[:, None] & np.isfinite(short)
        draws, left, x = draws[rows, kept], left[rows, kept], x[rows, kept]
        draws = np.where(in_elevation, draws - short, draws)
    records = observed_records(observations), mean_record_sigma(model)
    return ExpectedRecords(*records, draws, left, x, error_sign(observations))


def mean_record_sigma(model: FittedModel) -> Floats:
    """Error of the records `[n_events]` (m): root of its mean square over the posterior."""
    posterior, observations = model.posterior, model.observations
    if not of_kind(posterior.effects, RecordErrorEffect):
        return observations.recorded_sigma(observations.sigma)
    squares = [posterior.record_sigma(u) ** 2 for u in model.draws]
    return observations.recorded_sigma(np.sqrt(np.mean(squares, axis=0)))


def observed_records(observations: Observations) -> Floats:
    """The records `[n_events]` (m); a runout beyond the profile counts as its end."""
    observed = observations.as_recorded(observations.observed)
    return np.where(observations.kind == LEFT, profile_end(observations), observed)


def error_sign(observations: Observations) -> Floats:
    """-1 for an x or a length where elevations were recorded too, else 1, `[n_events]`."""
    farther_is_more = (observations.kind == PLACE) | (observations.kind == LENGTH)
    if np.all(farther_is_more | (observations.kind == LEFT)):
        return np.ones(observations.n_events)
    return np.where(farther_is_more, -1.0, 1.0)


def profile_end(observations: Observations) -> Floats:
    """The profile's end in the coordinate of each record, `[n_events]`; nan without a profile."""
    end, in_x = np.full(observations.n_events, np.nan), observations.kind == PLACE
    for k, site in enumerate(observations.sites):
        selected = observations.columns.path_index == k
        end[selected] = np.where(in_x[selected], site.smooth.x_max, site.end_y)
    return end


def _limits(posterior: Posterior, coordinates: Floats) -> Floats:
    """Elevation above which a stop is undetected, `[n_events, n_posterior]`; nan where all are."""
    observations = posterior.observations
    effects = of_kind(posterior.effects, LimitEffect)
    if not effects:
        return np.repeat(observations.limit[:, None], len(coordinates), axis=1)
    effect = effects[-1]
    each = [posterior.layout.effect_values(u)[effect.key] for u in coordinates]
    return np.column_stack([effect.limit(observations.columns, values) for values in each])


def _seen_first(excess: Floats, n_draws: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Index `[n_events, n_draws]` of draws that are seen; where too few are, some come twice.

    `excess` `[n_events, n_stops]` is by how much (m) each draw stops above the detection limit.
    Where hardly any is seen, those that come nearest count too.
    """
    chosen = np.empty((len(excess), n_draws), dtype=np.int64)
    for i, row in enumerate(excess):
        found = np.flatnonzero(row <= 0.0)
        if len(found) < FEWEST_SEEN:
            found = np.sort(np.argsort(row, kind="stable")[:FEWEST_SEEN])
        # Evenly over the posterior, which the draws run through in order.
        chosen[i] = (
            found[np.linspace(0, len(found) - 1, n_draws).round().astype(np.int64)]
            if len(found) >= n_draws
            else rng.choice(found, n_draws)
        )
    return chosen


CRPS_OF_NORMAL = 1.0 / np.sqrt(np.pi)
"""Expected CRPS of a normal forecast that is right, per standard deviation."""
PIT_BINS = 10
N_PLACES = 4001


def runout_scores(expected: ExpectedRecords, pit: Floats, floor: Floats) -> RunoutScores:
    """Scores of runouts, in metres of each record.

    `bias_m` is predicted mean minus record; where elevations are mixed with others, it counts as
    elevations do (> 0: recorded farther down than predicted). The measurement-error floor is that
    of records that scatter by `floor` `[n_events]` alone.
    """
    return RunoutScores(
        n=len(expected.observed),
        rmse_m=_root_mean_square(expected.error),
        bias_m=float(np.mean(expected.error)),
        crps_m=float(np.mean(crps(expected.draws, expected.observed))),
        coverage_50=_coverage(pit, 0.5),
        coverage_90=_coverage(pit, 0.9),
        noise_floor_m=_root_mean_square(floor),
        noise_floor_crps_m=float(CRPS_OF_NORMAL * np.mean(floor)),
        pit_histogram=tuple(np.histogram(pit, PIT_BINS, (0.0, 1.0))[0].tolist()),
    )


def speed_scores(speeds: MatchedSpeeds | None) -> SpeedScores | None:
    """Scores of speeds, m/s, over measured places; None without any."""
    if speeds is None:
        return None
    draws, observed = speeds.draws, speeds.observed
    error = draws.mean(axis=1) - observed
    pit = randomised_pit(draws, observed, generator(0, "speed scores"))
    return SpeedScores(
        n=len(observed),
        rmse_m_s=_root_mean_square(error),
        bias_m_s=float(np.mean(error)),
        crps_m_s=float(np.mean(crps(draws, observed))),
        coverage_50=_coverage(pit, 0.5),
        coverage_90=_coverage(pit, 0.9),
        noise_floor_m_s=_root_mean_square(speeds.sigma),
    )


def crps(draws: Floats, observed: Floats) -> Floats:
    """Continuous ranked probability score of each event `[n_events]` by draws `[n_events, n]`.

    The fair estimator, mean |X - y| - ½ mean |X - X'| (Ferro 2014), the latter mean from the
    sorted draws.
    """
    n = draws.shape[1]
    rank = 2.0 * np.arange(1, n + 1) - n - 1.0
    spread = np.sort(draws, axis=1) @ rank * 2.0 / (n * (n - 1.0))
    return np.asarray(np.mean(np.abs(draws - observed[:, None]), axis=1) - 0.5 * spread)


def record_pit(expected: ExpectedRecords, rng: np.random.Generator) -> Floats:
    """`randomised_pit` of the records `[n_events]`, in the direction of their `sign`."""
    pit = randomised_pit(expected.draws, expected.observed, rng)
    return np.where(expected.sign < 0.0, 1.0 - pit, pit)


def randomised_pit(draws: Floats, observed: Floats, rng: np.random.Generator) -> Floats:
    """Rank of each record among its draws, in (0, 1); ties and the last place are drawn at random.

    Uniform where the predictive distribution is right, also for records at a profile's end
    (Czado, Gneiting and Held 2009). Returns `[n_events]`.
    """
    below = np.sum(draws < observed[:, None], axis=1)
    equal = np.sum(draws == observed[:, None], axis=1)
    return np.asarray((below + rng.random(len(observed)) * (equal + 1)) / (draws.shape[1] + 1))


def _root_mean_square(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _coverage(pit: Floats, share: float) -> float:
    """Share of the records in the middle interval that should hold `share` of them."""
    return float(np.mean(np.abs(pit - 0.5) <= 0.5 * share))


def in_x(expected: ExpectedRecords, observations: Observations) -> ExpectedRecords | None:
    """The same in x (m) for the events with a profile; None where there is none.

    An elevation, recorded or drawn with the record's error, is put where the path first falls to
    it, as `stop_place` does; `sigma` is half of what ±sigma of elevation is along the path.
    """
    events = with_profile(observations)
    if not len(events):
        return None
    found = ExpectedRecords._make(of_all[events] for of_all in expected)
    for k, i in enumerate(events):
        if observations.kind[i] == PLACE:
            continue
        smooth = observations.sites[observations.columns.path_index[i]].smooth
        y, s = found.observed[k], found.sigma[k]
        higher, record, lower = _places(smooth, np.array([y + s, y, y - s]))
        # A runout beyond the profile counts as its end, on a counter-slope too.
        found.observed[k] = smooth.x_max if observations.kind[i] == LEFT else record
        found.sigma[k] = 0.5 * (lower - higher)
        found.draws[k] = np.where(found.left[k], smooth.x_max, _places(smooth, found.draws[k]))
    return found._replace(sign=np.ones(len(events)))


def x_scores(
    expected: ExpectedRecords, observations: Observations, floor: Floats
) -> RunoutScores | None:
    """`runout_scores` in x of the events with a profile; None without any."""
    found = in_x(expected, observations)
    if found is None:
        return None
    # What volumes do to the floor is in proportion to the errors of the records.
    wider = (floor / expected.sigma)[with_profile(observations)]
    pit = record_pit(found, generator(0, "scores in x"))
    return runout_scores(found, pit, found.sigma * wider)


def with_profile(observations: Observations) -> NDArray[np.int64]:
    """Indices of the events that have a profile."""
    return np.flatnonzero((observations.kind != LENGTH) & (observations.columns.path_index >= 0))


def _places(smooth: SmoothProfile, elevation: Floats) -> Floats:
    """x (m) `[n]` where the path first falls to elevations (m) `[n]`, its lowest place at most."""
    x = np.linspace(smooth.x_min, smooth.x_max, N_PLACES)
    lowest = np.minimum.accumulate(smooth.height(x))
    falling = np.concatenate([[True], np.diff(lowest) < 0.0])
    return np.asarray(np.interp(-elevation, -lowest[falling], x[falling]))
