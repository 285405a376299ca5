"""The figures of the paper that belong to models: posterior, residuals, friction against volume."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.model.friction_scatter import log_density
from avahazard.inference.paper.calibration import recorded_elevation
from avahazard.inference.prediction.fitted_model import FittedModel
from avahazard.inference.prediction.stops import look_up
from avahazard.records.errors import AvahazardError
from avahazard.store.models import load_model
from avahazard.store.session import reading
from avahazard.workflow.model_friction import apparent_friction, friction_view, from_reference
from avahazard.workflow.stored.model import load_parameter_draws, load_stored
from avahazard.workflow.stored.own_effects import effects_of, files_of, own_effects

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
            effects = effects_of(load_model(session, name))
        own = own_effects(database, name, files_of(effect_files, effects))
        stored.append(load_stored(database, name, own)[0])
    return stored


def plan_of_models(database: str, models: Sequence[FittedModel]) -> Iterator[Planned]:
    """What is drawn of models: two figures each, and one of all together."""
    for stored in models:
        yield Planned(
            "4, 6a-c",
            f"posterior of {stored.name}",
            f"4-6abc-posterior-{stored.name}",
            partial(_draw_posterior, database, stored),
            stored.name,
        )
        yield Planned(
            "6d",
            f"residuals of {stored.name}",
            f"6d-residuals-{stored.name}",
            partial(_draw_residuals, stored),
            stored.name,
        )
    if models:
        yield Planned(
            "5, 7", "friction against volume", "5-7-friction-volume", partial(_draw_laws, models)
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


def _draw_residuals(stored: FittedModel, file: Path) -> None:
    off, of = standardised_residuals(stored)
    off = off[np.isfinite(off)]
    if len(off) < FEWEST:
        raise AvahazardError(
            f"{len(off)} events have a volume and a friction; residuals need {FEWEST}."
        )
    x = np.linspace(-REACH, REACH, 401)
    student = stored.specification.tails == "student"
    density = (x, np.exp(log_density(x, student)))
    from avahazard.report.paper_pictures import draw_residuals  # noqa: PLC0415 (slow)

    draw_residuals(file, stored.name, off, density, of)


def _draw_posterior(database: str, stored: FittedModel, file: Path) -> None:
    from avahazard.report.paper_pictures import draw_posterior  # noqa: PLC0415 (slow)

    draws = load_parameter_draws(database, stored.name)
    units = {name: told.unit for name, told in stored.calibration.parameters.items()}
    draw_posterior(file, stored.name, {k: v.ravel() for k, v in draws.items()}, units)


def _draw_laws(models: Sequence[FittedModel], file: Path) -> None:
    from avahazard.report.paper_pictures import ModelLaw, draw_model_laws  # noqa: PLC0415

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
