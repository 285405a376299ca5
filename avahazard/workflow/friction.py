"""Apparent friction of the recorded events: its density, its laws, what errors of records do to it.

These are the views of Ancey (2005) of the records, for people, and every figure of it by one call.
Calibration does not use them. The block runs by itself, as in the paper, or with the effects of a
stored model, whose law and scatter are then shown beside the events.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.predicted import Predicted, predict_records
from avahazard.inference.model.friction_model import log_density
from avahazard.inference.model.laws import law, usable
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper import apparent
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.paper.least_squares import LawFit, fit_every_law, fit_law
from avahazard.inference.prediction import look_up
from avahazard.inference.seeds import generator
from avahazard.records.collection import only_paths
from avahazard.records.errors import AvahazardError
from avahazard.report.html.content import FrictionView
from avahazard.report.picture import require_picture
from avahazard.results import friction as results
from avahazard.results.base import Rows, finite
from avahazard.workflow.requests import FrictionRequest
from avahazard.workflow.stored import (
    load_parameter_draws,
    load_stored,
    notes_of_fit,
    on_events,
    records_of,
)

N_POINTS = 201
TAIL = 2.5
"""The density is given this many lengths 1/κ beyond the records: 99 % of its tails."""
LAW = "exponential"
"""The law whose spread under perturbation is reported, as in the paper."""


def friction_densities(
    mu: Floats, observations: Observations, kappa: float | str = apparent.DEFAULT_KAPPA
) -> Rows[results.FrictionDensity]:
    """Holy's density of all events and of each path that has at least two frictions.

    `mu` `[n_events]` are apparent frictions, nan where there is none; `kappa` as in
    `show_frictions`.
    """
    columns, known = observations.columns, np.isfinite(mu)
    groups = {"all": mu[known]}
    groups |= {name: mu[known & (columns.path_index == k)] for k, name in enumerate(columns.paths)}
    densities = []
    for name, of_group in groups.items():
        if len(of_group) < 2:
            continue
        width = apparent.choose_kappa(of_group) if isinstance(kappa, str) else kappa
        density = apparent.holy_density(of_group, width)
        x = np.linspace(density.mu[0] - TAIL / width, density.mu[-1] + TAIL / width, N_POINTS)
        densities.append(
            results.FrictionDensity(
                path_id=name,
                n=len(of_group),
                kappa=float(density.kappa),
                mu=tuple(x.tolist()),
                pdf=tuple(density.pdf(x).tolist()),
                extrapolated=tuple(density.extrapolated(x).tolist()),
                mean=float(np.mean(of_group)),
                sd=float(np.std(of_group, ddof=1)),
            )
        )
    return Rows(densities)


def perturbation_check(
    found: apparent.BackCalculation, observations: Observations
) -> results.PerturbationCheck:
    """What the errors of the records do to the frictions, and to the law fitted to them."""
    sd = found.mu_sd[np.isfinite(found.mu_sd)]
    volume = np.exp(observations.columns.log_volume)
    check = results.PerturbationCheck(
        n_replicates=apparent.N_REPLICATES,
        n_events=len(sd),
        mu_sd_median=float(np.median(sd)) if len(sd) else None,
        mu_sd_max=float(np.max(sd)) if len(sd) else None,
        law=None,
        parameters={},
    )
    try:
        fit = fit_law(law(LAW), volume, found.mu)
        moved = np.array([fit_law(law(LAW), volume, mu).parameters for mu in found.moved])
    except AvahazardError:  # too few events with a volume for a law
        return check
    figures = fit.parameters, fit.standard_errors, moved.mean(axis=0), moved.std(axis=0, ddof=1)
    parameters = map(results.PerturbedParameter, *(values.tolist() for values in figures))
    return replace(check, law=LAW, parameters=dict(zip(fit.law.names, parameters, strict=True)))


N_VOLUMES = 60
N_PARAMETERS = 1000
DRAWS_EACH = 8
ROOM = 1.5
"""The curve goes on beyond the smallest and largest volume by this factor."""


def friction_view(model: FittedModel) -> FrictionView | None:
    """The calibrated friction over the recorded volumes; None where none is recorded.

    Effects on friction are at their reference, and the spread between paths is left out, as they
    are from `EventView.mu_reference`.
    """
    recorded = model.columns.log_volume
    recorded = recorded[np.isfinite(recorded)]
    if not len(recorded):
        return None
    volume = np.geomspace(np.exp(recorded.min()) / ROOM, np.exp(recorded.max()) * ROOM, N_VOLUMES)
    u = model.draws[model.thinned(min(len(model.draws), N_PARAMETERS))]
    law, scatter = model.layout.law, None
    middle = law.log_friction(u[:, : len(law.coordinates)], volume)
    if model.sigma_m is None:
        shape, rng = (DRAWS_EACH, len(u), len(volume)), generator(0, "report", "friction")
        about = model.friction.location_and_scatter(u, volume[None])
        location, spread = (np.broadcast_to(v[:, 0], shape) for v in about)
        drawn = model.friction.draw(u[:, None], location, spread, rng).reshape(-1, len(volume))
        scatter = np.quantile(drawn, [0.05, 0.25, 0.75, 0.95], axis=0)
    return FrictionView(volume, np.exp(np.quantile(middle, [0.05, 0.5, 0.95], axis=0)), scatter)


def apparent_friction(model: FittedModel) -> tuple[apparent.BackCalculation, Predicted]:
    """Friction that stops each event's block at its record, with the model's effects at work.

    Effects on the motion and on the record stand at the median of the posterior: so the
    frictions are those that the model's law is a law of. Also what was turned round for it.
    """
    observations = model.observations
    values = model.layout.effect_values(np.median(model.draws, axis=0))
    curvature = float(model.specification.centrifugal)
    predicted = predict_records(observations, model.effects, values, curvature)
    return apparent.back_calculate(observations, predicted), predicted


def from_reference(model: FittedModel) -> Floats:
    """What effects on friction and the path add to log friction `[n_events]`, at the median.

    Less of them, a friction may stand beside the law alone. nan for an event without a volume.
    """
    middle, by_law, _ = _located(model)
    return np.where(np.isfinite(model.columns.log_volume), middle - by_law, np.nan)


def _located(model: FittedModel) -> tuple[Floats, Floats, Floats]:
    """Log friction of the events at the median of the posterior, by the law alone, and the scatter.

    `[n_events]` each; an event without a volume has some volume.
    """
    friction, columns, layout = model.friction, model.columns, model.layout
    u = np.median(model.draws, axis=0)
    volume = np.exp(columns.log_volume)
    known = np.where(np.isfinite(volume), volume, 1e4)
    events = friction.of_events(columns)
    location, scatter = friction.location_and_scatter(u, known[:, None], events)
    middle = location[:, 0] if layout.log_scatter else np.log(location[:, 0])
    by_path = [
        float(np.median(model.offsets[p])) if p in model.offsets else 0.0 for p in columns.paths
    ]
    middle = middle + np.array([*by_path, 0.0])[columns.path_index]
    law = layout.law
    return middle, law.log_friction(u[: len(law.coordinates)], known), scatter[:, 0]


BY_ITSELF = FrictionRequest()


def show_frictions(
    database: str, path_id: str | None = None, request: FrictionRequest = BY_ITSELF
) -> results.Frictions:
    """The apparent friction of every event, of one path or all.

    `kappa` "auto" takes, for each density, that with the best held-out likelihood. With `model` the
    events are those that it was calibrated on, or the path's. `plot` is a picture of the densities,
    and by a model also of its law with the events. Raises `AvahazardError` where the database, the
    model or the path is missing, there are no events, a path of theirs has no profile, or `plot` is
    not the name of a picture.
    """
    plot, model = request.plot, request.model
    require_picture(plot)
    fitted = reference = None
    if model is not None:
        fitted, records = load_stored(database, model, request.effect_files)
        if path_id is not None:
            fitted = on_events(fitted, records, only_paths(records, (path_id,)).events)
        observations = fitted.observations
        found, _ = apparent_friction(fitted)
        reference = found.mu * np.exp(-from_reference(fitted))
    else:
        observations = _observed(database, path_id)
        found = apparent.back_calculate(observations, predict_records(observations, (), {}))
    frictions = results.Frictions(
        model=model,
        notes=None if fitted is None else notes_of_fit(fitted),
        events=_events(found, observations, reference),
        density=friction_densities(found.mu, observations, request.kappa),
        perturbation=perturbation_check(found, observations),
    )
    if plot is not None:
        from avahazard.report.plots import draw_frictions, law_figure  # noqa: PLC0415

        drawn = None
        if fitted and reference is not None and (view := friction_view(fitted)):
            drawn = law_figure(view, np.exp(observations.columns.log_volume), reference)
        draw_frictions(plot, frictions, drawn)
    return frictions


def _observed(database: str, path_id: str | None) -> Observations:
    """The events of one path or of all."""
    records = records_of(database)
    return build_observations(only_paths(records, () if path_id is None else (path_id,)))


def _events(
    found: apparent.BackCalculation, observations: Observations, reference: Floats | None
) -> Rows[results.ApparentEvent]:
    columns = observations.columns
    return Rows(
        results.ApparentEvent(
            event_id=columns.event_id[i],
            path_id=columns.paths[k] if k >= 0 else None,
            mu=finite(found.mu[i]),
            mu_sd=finite(found.mu_sd[i]),
            status=apparent.STATUSES[found.status[i]],
            mu_low=finite(found.mu_low[i]),
            mu_high=finite(found.mu_high[i]),
            mu_reference=None if reference is None else finite(reference[i]),
        )
        for i, k in enumerate(columns.path_index)
    )


def fit_laws(database: str, path_id: str | None = None, plot: Path | None = None) -> results.Fits:
    """Fit every law to the events with a volume and a friction, of one path or of all.

    `plot` is a picture of the laws on the points. Raises `AvahazardError` where the database or the
    path is missing, there are too few such events, or `plot` is not the name of a picture.
    """
    require_picture(plot)
    observations = _observed(database, path_id)
    mu = apparent.back_calculate(observations, predict_records(observations, (), {})).mu
    volume = np.exp(observations.columns.log_volume)
    n_events = int(np.sum(np.isfinite(mu) & np.isfinite(volume)))
    if n_events < 2:
        raise AvahazardError(
            "A law needs events with a volume and an apparent friction; "
            f"there {'is' if n_events == 1 else 'are'} {n_events or 'none'}.",
            "Import events with volume_m3, or with the deposit's length, width and thickness.",
        )
    fits, notes = fit_every_law(volume, mu)
    if left_out := observations.n_events - n_events:
        notes.append(
            f"left out of {observations.n_events} events: {left_out}, without a volume, or stopped "
            "where no friction stops the block (see `avahazard friction`)."
        )
    found = results.Fits(Rows(_entry(fit, n_events) for fit in fits), tuple(notes))
    if plot is not None:
        from avahazard.report.plots import draw_laws  # noqa: PLC0415 (slow)

        draw_laws(plot, found, *usable(volume, mu))
    return found


def _entry(fit: LawFit, n_events: int) -> results.LeastSquares:
    values, errors = fit.parameters.tolist(), fit.standard_errors.tolist()
    parameters = map(results.FittedParameter, values, errors, fit.law.units)
    return results.LeastSquares(
        law=fit.law.name,
        parameters=dict(zip(fit.law.names, parameters, strict=True)),
        covariance=tuple(tuple(row) for row in fit.covariance.tolist()),
        r2=float(fit.r2),
        aic=float(fit.aic),
        n_events=n_events,
    )


FEWEST = 3
REACH = 5.0
"""The model's scatter is drawn over so many σ on either side."""


def standardised_residuals(model: FittedModel) -> tuple[Floats, str]:
    """What each record is off by, over the scatter σ of the model, `[n_events]`; and of what.

    Of log friction (of friction, where that is normal): the apparent friction less the median of
    its event. By metropolis, whose σ is one of the stop: recorded elevation less F(G(V)). All at
    the median of the posterior; nan for an event without a volume or without a friction.
    """
    found, predicted = apparent_friction(model)
    volume = np.exp(model.columns.log_volume)
    if model.sigma_m is not None:
        median = model.median_friction(np.where(np.isfinite(volume), volume, 1.0))
        stop = look_up(predicted, median[:, None])[2][:, 0]
        off = (recorded_elevation(model.observations) - stop) / float(np.median(model.sigma_m))
        return np.where(np.isfinite(volume), off, np.nan), "elevation"
    middle, _, scatter = _located(model)
    middle = np.where(np.isfinite(volume), middle, np.nan)
    if model.layout.log_scatter:
        return (np.log(found.mu) - middle) / scatter, "log μ"
    return (found.mu - np.exp(middle)) / scatter, "μ"


def plot_residuals(stored: FittedModel, file: Path) -> None:
    """The standardised residuals of the events beside the scatter of the model.

    Raises `AvahazardError` where fewer than `FEWEST` events have a volume and a friction.
    """
    off, of = standardised_residuals(stored)
    off = off[np.isfinite(off)]
    if len(off) < FEWEST:
        raise AvahazardError(
            f"{len(off)} events have a volume and a friction; residuals need {FEWEST}."
        )
    x = np.linspace(-REACH, REACH, 401)
    density = x, np.exp(log_density(x, stored.specification.tails == "student"))
    from avahazard.report.plots import draw_residuals  # noqa: PLC0415 (slow)

    draw_residuals(file, stored.name, off, density, of)


def plot_posterior(database: str, stored: FittedModel, file: Path) -> None:
    """The posterior of each parameter, with its normal."""
    from avahazard.report.figure_pictures import draw_figures  # noqa: PLC0415 (slow)
    from avahazard.report.html.model_figures import posterior_figures  # noqa: PLC0415 (slow)

    draws = {k: v.ravel() for k, v in load_parameter_draws(database, stored.name).items()}
    figures = posterior_figures(stored.calibration.parameters, draws)
    title = f"Posterior of {stored.name}, with normal approximations"
    draw_figures(file, title, figures, columns=3)
