"""Every figure of Ancey (2005), drawn from the records and models of a database by one call."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.fitted_model import FittedModel
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.friction_scatter import log_density
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper.apparent import BackCalculation, back_calculate
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.paper.density import DEFAULT_KAPPA, density_band
from avahazard.inference.prediction import look_up
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.results.base import Report, Rows, silent
from avahazard.results.friction import FrictionDensity
from avahazard.results.made import PaperFigure
from avahazard.store.records import load_records
from avahazard.store.results import load_model
from avahazard.store.session import reading
from avahazard.workflow.effects import files_of
from avahazard.workflow.friction import (
    apparent_friction,
    fit_laws_of,
    friction_densities,
    friction_view,
    from_reference,
)
from avahazard.workflow.requests import FiguresRequest, RunoutRequest
from avahazard.workflow.runout import run_block
from avahazard.workflow.stored import load_parameter_draws, load_stored

MU_SHOWN = 0.4
"""The friction marked on F(μ) of a path whose events tell none."""


def paper_figures(
    database: str, names: Sequence[str], request: FiguresRequest, report: Report = silent
) -> Rows[PaperFigure]:
    """Draw the figures of the paper into a folder, which is made where it is not there.

    Of the records: laws by least squares, densities of apparent friction with their normals, F(μ)
    and F′ of each path. Of the models `names`: the posterior with its normals, residuals with
    theirs, and friction against volume with all models in one picture. What the records do not
    allow is a row without a file, and why. Raises `AvahazardError` where the database, a path or a
    model is missing, there are no events, or the folder is a file.
    """
    folder = request.folder
    if folder.exists() and not folder.is_dir():
        raise AvahazardError(f"{folder} is a file.", "Name a folder for the figures: -o figures")
    with reading(database) as session:
        records = only_paths(load_records(session), request.paths)
    observations = build_observations(records)
    models = load_models(database, names, request.effect_files)
    folder.mkdir(parents=True, exist_ok=True)
    planned = [*_of_records(database, records, observations), *plan_of_models(database, models)]
    made = []
    for done, item in enumerate(planned):
        report(f"Drawing {item.shows}", float(done), float(len(planned)))
        made.append(_drawn(item, folder / f"{item.stem}.{request.kind}"))
    return Rows(made)


def _drawn(item: Planned, file: Path) -> PaperFigure:
    """Draw one figure; where the data do not allow it, why."""
    try:
        item.draw(file)
    except AvahazardError as error:
        return PaperFigure(item.figure, item.shows, item.model, None, (error.message,))
    return PaperFigure(item.figure, item.shows, item.model, str(file))


def _of_records(database: str, records: Records, observations: Observations) -> Iterator[Planned]:
    """What needs no model."""
    found = back_calculate(observations, predict_records(observations, (), {}))
    densities = friction_densities(found.mu, observations)
    frictions = {d.path_id: _frictions(found, observations, d.path_id) for d in densities}
    whole = [d for d in densities if d.path_id == "all"]
    yield Planned("1", "laws by least squares", "1-laws", partial(_draw_fits, observations, found))
    yield Planned(
        "2",
        "density of apparent friction",
        "2-friction",
        partial(_draw_densities, "Apparent friction", whole, frictions, found),
    )
    yield Planned(
        "3",
        "the same by path",
        "3-friction-by-path",
        partial(
            _draw_densities,
            "Apparent friction by path",
            [d for d in densities if d.path_id != "all"],
            frictions,
            None,
        ),
    )
    for profile in records.profiles:
        mu = frictions.get(profile.path_id)
        at = MU_SHOWN if mu is None else float(np.median(mu))
        yield Planned(
            "F",
            f"F(μ) and F′ of {profile.path_id}",
            f"F-{profile.path_id}",
            partial(_draw_runout, database, profile.path_id, at),
        )


def _draw_runout(database: str, path_id: str, mu: float, file: Path) -> None:
    run_block(database, path_id, RunoutRequest(mu=mu, table=True, plot=file))


def _frictions(found: BackCalculation, observations: Observations, name: str) -> Floats:
    """The apparent frictions `[n]` of a density's events."""
    columns = observations.columns
    mine = np.isfinite(found.mu)
    if name != "all":
        mine &= columns.path_index == columns.paths.index(name)
    return found.mu[mine]


def _draw_fits(observations: Observations, found: BackCalculation, file: Path) -> None:
    fits, volume, mu = fit_laws_of(observations, found.mu)
    from avahazard.report.friction_pictures import draw_laws  # noqa: PLC0415 (slow)

    draw_laws(file, fits, volume, mu)


def _draw_densities(
    title: str,
    densities: Sequence[FrictionDensity],
    frictions: dict[str, Floats],
    moved: BackCalculation | None,
    file: Path,
) -> None:
    """`moved` holds the records moved within their errors, for the band of the first density."""
    if not densities:
        raise AvahazardError("There are no two events with an apparent friction on one path.")
    from avahazard.report.friction_pictures import draw_with_normals  # noqa: PLC0415 (slow)

    bands = {}
    if moved is not None:
        first = densities[0]
        bands[first.path_id] = density_band(
            moved.perturbation.mu, np.array(first.mu), DEFAULT_KAPPA
        )
    draw_with_normals(file, title, densities, frictions, bands)


FEWEST = 3
REACH = 5.0
"""The model's scatter is drawn over so many σ on either side."""


@dataclass(frozen=True, slots=True)
class Planned:
    """A figure to draw: its number in the paper, what it shows, its file's stem, and how."""

    figure: str
    shows: str
    stem: str
    draw: Callable[[Path], Any]
    model: str | None = None


def load_models(
    database: str, names: Sequence[str], effect_files: Sequence[Path]
) -> list[FittedModel]:
    """The stored models, each with those of the effect files that are its own."""
    stored = []
    for name in dict.fromkeys(names):
        with reading(database) as session:
            effects = load_model(session, name).effects
        stored.append(load_stored(database, name, files_of(effect_files, effects))[0])
    return stored


def plan_of_models(database: str, models: Sequence[FittedModel]) -> Iterator[Planned]:
    """What is drawn of models: two figures each, and one of all together."""
    for stored in models:
        yield Planned(
            "4, 6a-c",
            f"posterior of {stored.name}",
            f"4-6abc-posterior-{stored.name}",
            partial(plot_posterior, database, stored),
            stored.name,
        )
        yield Planned(
            "6d",
            f"residuals of {stored.name}",
            f"6d-residuals-{stored.name}",
            partial(plot_residuals, stored),
            stored.name,
        )
    if models:
        yield Planned(
            "5, 7", "friction against volume", "5-7-friction-volume", partial(plot_laws, models)
        )


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
    friction, layout = model.friction, model.layout
    u = np.median(model.draws, axis=0)
    known = np.where(np.isfinite(volume), volume, 1e4)[:, None]
    events = friction.of_events(model.columns)
    _, scatter = friction.location_and_scatter(u, known, events)
    law = layout.law
    reference = law.log_friction(u[: len(law.coordinates)], known[:, 0])
    middle = reference + from_reference(model)
    if layout.log_scatter:
        return (np.log(found.mu) - middle) / scatter[:, 0], "log μ"
    return (found.mu - np.exp(middle)) / scatter[:, 0], "μ"


def plot_residuals(stored: FittedModel, file: Path) -> None:
    """The standardised residuals of the events beside the scatter of the model."""
    off, of = standardised_residuals(stored)
    off = off[np.isfinite(off)]
    if len(off) < FEWEST:
        raise AvahazardError(
            f"{len(off)} events have a volume and a friction; residuals need {FEWEST}."
        )
    x = np.linspace(-REACH, REACH, 401)
    student = stored.specification.tails == "student"
    density = (x, np.exp(log_density(x, student)))
    from avahazard.report.friction_pictures import draw_residuals  # noqa: PLC0415 (slow)

    draw_residuals(file, stored.name, off, density, of)


def plot_posterior(database: str, stored: FittedModel, file: Path) -> None:
    """The posterior of each parameter, with its normal."""
    from avahazard.report.friction_pictures import draw_posterior  # noqa: PLC0415 (slow)

    draws = load_parameter_draws(database, stored.name)
    units = {name: told.unit for name, told in stored.calibration.parameters.items()}
    draw_posterior(file, stored.name, {k: v.ravel() for k, v in draws.items()}, units)


def plot_laws(models: Sequence[FittedModel], file: Path) -> None:
    """Friction against volume of all models, with the events."""
    from avahazard.report.friction_pictures import ModelLaw, draw_model_laws  # noqa: PLC0415

    laws = []
    for stored in models:
        view = friction_view(stored)
        if view is None:
            continue
        mu = apparent_friction(stored)[0].mu * np.exp(-from_reference(stored))
        volume = np.exp(stored.columns.log_volume)
        laws.append(ModelLaw(stored.name, view, volume, mu))
    if not laws:
        raise AvahazardError("No event of these models has a volume.")
    draw_model_laws(file, laws)
