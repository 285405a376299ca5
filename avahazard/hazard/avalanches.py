"""What comes down a path in a year: rates, volumes and frictions, by posterior draw.

The block's stop, and its speed at any place, fall steadily as friction rises. So the rate of
avalanches that pass a place, or are faster there, is the rate of those whose friction is under a
threshold, and that is a sum of normal probabilities: no avalanche needs to be drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtr

from avahazard.effects.site import Site
from avahazard.hazard.event_volumes import EventVolumes
from avahazard.hazard.posterior_draws import PosteriorDraws, posterior_draws
from avahazard.hazard.rate_kernel import normal_rates
from avahazard.inference.likelihood.posterior import Posterior
from avahazard.inference.likelihood.predicted import Predicted, Values
from avahazard.inference.model.observations import Observations
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.physics.resistance import Resistance

Floats = NDArray[np.float64]
Thresholds = Callable[[Floats], Floats]
"""Maps a level `[n_parameters]` to the friction under which a block of each class exceeds it,
`[n_parameters, n_classes]`."""

STUDENT_DF = 4.0
LEAST_SCATTER = 1e-9
HALVINGS = 24


@dataclass(frozen=True, slots=True, eq=False)
class Avalanches:
    """Avalanches of one path: classes of release and columns, volumes, and posterior draws.

    Of `volumes.rate` `[n_parameters]` avalanches a year `class_share` `[n_classes]` are of each
    class, whatever the volume. Friction has `location` (log μ, or μ where it is normal) and
    `scatter`, both `[n_parameters, n_classes, n_volumes]`; path offsets are in them. Draw p runs
    by `tables[group[p]]`, of which row c is that of class c; `values` are the effects' parameters
    there, and `ahead` `[n_groups][n_classes]` is how far (m) the front is ahead of the block.
    `sigma_m` `[n_parameters]`: the stops scatter in metres instead (metropolis).
    """

    path_id: str
    site: Site
    release: NDArray[np.int64]
    volumes: EventVolumes
    class_share: Floats
    location: Floats
    scatter: Floats
    group: NDArray[np.int64]
    tables: tuple[Predicted, ...]
    values: tuple[Values, ...]
    resistances: tuple[Resistance, ...]
    ahead: tuple[Floats, ...]
    in_log: bool
    student: bool
    sigma_m: Floats | None

    @property
    def n_parameters(self) -> int:
        """Number of posterior draws."""
        return len(self.location)

    @property
    def n_classes(self) -> int:
        """Number of classes of release and columns."""
        return len(self.class_share)


def avalanches(
    model: FittedModel, path_id: str, volumes: EventVolumes, rng: np.random.Generator
) -> Avalanches:
    """Avalanches of a path by a model.

    The events of `model` are one for each class, all of this path and equally frequent. The
    posterior of the model is spread over the draws of `volumes`, which know nothing of each
    other.
    """
    posterior, n = model.posterior, len(volumes.rate)
    draws = posterior_draws(model, n)
    # Fewer draws of the model than of the volumes serve several times.
    again = np.arange(n) * len(draws.u) // n
    location, scatter = _friction(posterior, draws, path_id, volumes.log_volume, rng)
    specification = posterior.specification
    n_classes = posterior.observations.n_events
    site = posterior.observations.sites[0]
    return Avalanches(
        path_id=path_id,
        site=site,
        release=posterior.observations.release,
        volumes=volumes,
        class_share=np.full(n_classes, 1.0 / n_classes),
        location=location[again],
        scatter=scatter[again],
        group=draws.group[again],
        tables=draws.tables,
        values=draws.values,
        resistances=tuple(posterior.resistance(site, values) for values in draws.values),
        ahead=tuple(_ahead(posterior, values) for values in draws.values),
        in_log=specification.distribution == "lognormal",
        student=specification.tails == "student",
        sigma_m=None if draws.sigma_m is None else draws.sigma_m[again],
    )


def _friction(
    posterior: Posterior,
    draws: PosteriorDraws,
    path_id: str,
    log_volume: Floats,
    rng: np.random.Generator,
) -> tuple[Floats, Floats]:
    """Location and scatter `[n_parameters, n_classes, n_volumes]`, the path's offset in them."""
    observations = posterior.observations
    shape = (observations.n_events, len(log_volume))
    many = Posterior(
        _at_volumes(observations, log_volume),
        posterior.specification,
        posterior.effects,
        {slot.name: slot.grid for slot in posterior.layout.slots if slot.grid},
    )
    volume = np.exp(np.tile(log_volume, observations.n_events))[:, None]
    location = np.empty((len(draws.u), *shape))
    scatter = np.empty_like(location)
    for p, row in enumerate(draws.u):
        m, s = many.location_and_scatter(row, volume)
        location[p], scatter[p] = m.reshape(shape), s.reshape(shape)
    shift = draws.path_shift(path_id, rng)[:, None, None]
    if posterior.layout.log_scatter:
        return location + shift, scatter
    return location * np.exp(shift), scatter


def _ahead(posterior: Posterior, values: Values) -> Floats:
    """Metres of the front ahead of the block for each class `[n_classes]`."""
    columns = posterior.observations.columns
    total = np.zeros(posterior.observations.n_events)
    for effect in posterior.effects:
        if effect.advance is not None:
            total = total + effect.advance(columns, values[effect.key])
    return total


def _at_volumes(observations: Observations, log_volume: Floats) -> Observations:
    """Every event of the observations once for each volume: columns only, it cannot be run."""
    n = len(log_volume)
    columns = observations.columns
    nodes = np.repeat(observations.volumes.log_volume, n, axis=0)
    return replace(
        observations,
        columns=replace(
            columns,
            event_id=tuple(name for name in columns.event_id for _ in range(n)),
            path_index=np.repeat(columns.path_index, n),
            year=np.repeat(columns.year, n),
            day_of_winter=np.repeat(columns.day_of_winter, n),
            release_elevation=np.repeat(columns.release_elevation, n),
            deposit_length=np.repeat(columns.deposit_length, n),
            stop_elevation=np.repeat(columns.stop_elevation, n),
            section=np.repeat(columns.section, n),
            log_volume=np.tile(log_volume, len(columns)),
            numbers={name: np.repeat(v, n) for name, v in columns.numbers.items()},
            texts={name: np.repeat(v, n) for name, v in columns.texts.items()},
        ),
        volumes=replace(observations.volumes, log_volume=nodes),
        observed=np.repeat(observations.observed, n),
    )


def _distribution(ready: Avalanches, z: Floats) -> Floats:
    """Chance under z standard scatters."""
    return np.asarray(stdtr(STUDENT_DF, z) if ready.student else ndtr(z))


def _scatter(ready: Avalanches) -> Floats:
    """The scatter of friction, which a model with scatter in metres has none of."""
    whole = np.zeros_like(ready.scatter) if ready.sigma_m is not None else ready.scatter
    return np.maximum(whole, LEAST_SCATTER)


def friction_below(ready: Avalanches, mu: Floats) -> Floats:
    """Chance that the friction of an avalanche lies under `mu` `[n_parameters, n_classes]`.

    The chance is `[n_parameters, n_classes, n_volumes]`; friction that is normal is taken given
    that it is over 0.
    """
    scatter = _scatter(ready)
    mu = np.maximum(mu, 0.0)[:, :, None]
    if ready.in_log:
        with np.errstate(divide="ignore"):
            return _distribution(ready, (np.log(mu) - ready.location) / scatter)
    impossible = _distribution(ready, -ready.location / scatter)
    under = _distribution(ready, (mu - ready.location) / scatter)
    return np.asarray((under - impossible) / np.maximum(1.0 - impossible, 1e-300))


def rate_below(ready: Avalanches, mu: Floats) -> Floats:
    """Yearly rate `[n_parameters]` of avalanches with friction under `mu`, by class.

    `mu` is `[n_parameters, n_classes]`: 0 for a class that never counts, inf for one that
    always does.
    """
    if ready.student:
        return yearly_rate(ready, friction_below(ready, mu))
    volumes = ready.volumes
    rates = normal_rates(
        *(mu, ready.in_log, ready.location, _scatter(ready)),
        *(volumes.share, ready.class_share, volumes.rate),
    )
    return np.asarray(rates)


def yearly_rate(ready: Avalanches, chance: Floats) -> Floats:
    """Yearly rate `[n_parameters]` of what has this chance for an avalanche.

    `chance` `[n_parameters, n_classes, n_volumes]`, of each class and volume.
    """
    by_class = np.einsum("pcv,pv->pc", chance, ready.volumes.share)
    return np.asarray(ready.volumes.rate * (by_class @ ready.class_share))


def exceeded(
    rate_over: Callable[[Floats], Floats], rate: Floats | float, low: float, high: float, n: int
) -> Floats:
    """The level `[n]` that is exceeded at a yearly `rate` (`[n]` or one for all), by bisection.

    `rate_over` maps levels `[n]` to the yearly rates of what exceeds them, falling in the level.
    The result is `high` or inf: inf where even `high` is exceeded more often; `low` where `low`
    is exceeded less often.
    """
    bottom, top = np.full(n, low), np.full(n, high)
    beyond = rate_over(top) >= rate
    for _ in range(HALVINGS):
        middle = 0.5 * (bottom + top)
        often = rate_over(middle) >= rate
        bottom, top = np.where(often, middle, bottom), np.where(often, top, middle)
    # Nothing was ever often enough: the lowest level itself.
    level = np.where(bottom == low, low, 0.5 * (bottom + top))
    return np.where(beyond, np.inf, level)


def annual_rate(return_period_years: float) -> float:
    """The yearly rate at which a year has one or more with chance 1/T: -log(1 - 1/T); T > 1."""
    return float(-np.log1p(-1.0 / return_period_years))
