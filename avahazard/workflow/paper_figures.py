"""Every figure of Ancey (2005), drawn from the records and models of a database by one call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from avahazard.arrays import Floats
from avahazard.inference.likelihood.predicted import predict_records
from avahazard.inference.model.observations import Observations, build_observations
from avahazard.inference.paper.apparent import BackCalculation, back_calculate
from avahazard.inference.paper.density import DEFAULT_KAPPA, density_band
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.lookup import only_paths
from avahazard.report.picture import FORMATS
from avahazard.results.base import Report, Rows, silent
from avahazard.results.friction import FrictionDensity
from avahazard.results.made import PaperFigure
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.fit import fit_laws_of
from avahazard.workflow.friction_views import friction_densities
from avahazard.workflow.paper_models import Planned, load_models, plan_of_models
from avahazard.workflow.runout import run_path

KINDS = tuple(name.removeprefix(".") for name in FORMATS)
MU_SHOWN = 0.4
"""The friction marked on F(μ) of a path whose events tell none."""


def paper_figures(
    database: str,
    names: Sequence[str],
    folder: Path,
    *,
    paths: Sequence[str] = (),
    kind: str = "png",
    effect_files: Sequence[Path] = (),
    report: Report = silent,
) -> Rows[PaperFigure]:
    """Draw the figures of the paper into `folder`, which is made where it is not there.

    Of the records (of `paths`, none: all): laws by least squares, densities of apparent friction
    with their normals, F(μ) and F′ of each path. Of the models `names`: the posterior with its
    normals, residuals with theirs, and friction against volume with all models in one picture.
    What the records do not allow is a row without a file, and why.

    Raises:
        AvahazardError: the database, a path or a model is missing, there are no events, `kind`
            is no kind of picture, or `folder` is a file.
    """
    if kind not in KINDS:
        raise AvahazardError(f"'{kind}' is no kind of picture.", f"Kinds: {', '.join(KINDS)}.")
    if folder.exists() and not folder.is_dir():
        raise AvahazardError(f"{folder} is a file.", "Name a folder for the figures: -o figures")
    with reading(database) as session:
        records = only_paths(load_records(session), tuple(paths))
    observations = build_observations(records)
    models = load_models(database, names, effect_files)
    folder.mkdir(parents=True, exist_ok=True)
    planned = [*_of_records(database, records, observations), *plan_of_models(database, models)]
    made = []
    for done, item in enumerate(planned):
        report(f"Drawing {item.shows}", float(done), float(len(planned)))
        made.append(_drawn(item, folder / f"{item.stem}.{kind}"))
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
    yield Planned("1", "laws by least squares", "1-laws", partial(_draw_laws, observations, found))
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
    run_path(database, path_id, mu, table=True, plot=file)


def _frictions(found: BackCalculation, observations: Observations, name: str) -> Floats:
    """The apparent frictions `[n]` of a density's events."""
    columns = observations.columns
    mine = np.isfinite(found.mu)
    if name != "all":
        mine &= columns.path_index == columns.paths.index(name)
    return found.mu[mine]


def _draw_laws(observations: Observations, found: BackCalculation, file: Path) -> None:
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
    from avahazard.report.paper_pictures import draw_with_normals  # noqa: PLC0415 (slow)

    bands = {}
    if moved is not None:
        first = densities[0]
        bands[first.path_id] = density_band(
            moved.perturbation.mu, np.array(first.mu), DEFAULT_KAPPA
        )
    draw_with_normals(file, title, densities, frictions, bands)
