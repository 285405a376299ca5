"""Regions and models as objects, for notebooks and scripts; each method calls one use case.

A method takes the fields of its request (`workflow.requests`) by keyword, with their types.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial, wraps
from importlib import import_module
from inspect import signature
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import (
    TYPE_CHECKING,
    Any,
    Concatenate,
    Literal,
    ParamSpec,
    Protocol,
    TypeVar,
    cast,
    overload,
)

import numpy as np
from numpy.typing import NDArray

import avahazard.report.picture  # noqa: F401 (how results are drawn)
from avahazard import workflow
from avahazard.progress import show_progress
from avahazard.records.collection import Event, Profile
from avahazard.records.errors import AvahazardError, did_you_mean, interruptible
from avahazard.request import Request
from avahazard.results.base import Rows, drawn
from avahazard.results.calibration import Calibration, EffectEntry, ModelSummary
from avahazard.results.comparison import Comparison, Ladder, Prediction
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.files import Export, Import, WrittenReport
from avahazard.results.friction import Fits, Frictions
from avahazard.results.hazard import Hazard, Volumes, Zones
from avahazard.results.terrain import PathCheck, PathSummary, Runout, TerrainRunout
from avahazard.workflow import requests

if TYPE_CHECKING:
    from avahazard.inference.fitted_model import FittedModel

Files = str | Path | Sequence[str | Path]
Folder = TemporaryDirectory[str] | None
Asked = ParamSpec("Asked")
Query = TypeVar("Query", bound=Request)
Query_co = TypeVar("Query_co", bound=Request, covariant=True)
Own = TypeVar("Own")
First = TypeVar("First")
Found = TypeVar("Found")


def _files(named: Files) -> tuple[Path, ...]:
    """The files of one name or several."""
    if hasattr(named, "to_csv"):
        raise AvahazardError(
            "A frame of pandas is no file.", 'Write it first: frame.to_csv("events.csv").'
        )
    return tuple(map(Path, [named] if isinstance(named, str | Path) else named))


def _database(named: str | Path) -> str:
    """A database by its whole path, wherever a notebook goes from here; a URL as it is."""
    if "://" in str(named):
        return str(named)
    return str(Path(named).expanduser().absolute())


class Taking(Protocol[Asked, Query_co]):
    """Turns a method that takes a request at its end into one that takes its fields by keyword."""

    @overload
    def __call__(
        self, method: Callable[[Own, Query_co], Found], /
    ) -> Callable[Concatenate[Own, Asked], Found]: ...
    @overload
    def __call__(
        self, method: Callable[[Own, First, Query_co], Found], /
    ) -> Callable[Concatenate[Own, First, Asked], Found]: ...


def taking(request: Callable[Asked, Query]) -> Taking[Asked, Query]:
    """Let a method take the fields of its `request` by keyword, less those that its object has."""
    options = signature(request).parameters

    def decorated(method: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(method)
        def asked(own: Any, *given: Any, **told: Any) -> Any:
            by_name = {p.name: told.pop(p.name) for p in before[1:] if p.name in told}
            for name in told.keys() - shown.keys():
                close = did_you_mean(name, shown).strip()
                raise AvahazardError(f"There is no option '{name}' here.", close)
            of_object = own._known if isinstance(own, Model) else {}
            known = {name: value for name, value in of_object.items() if name in options}
            if "effect_files" in known:
                known["effect_files"] += _files(told.get("effect_files", ()))
            return method(own, *given, **by_name, request=cast(Any, request)(**told | known))

        # A model runs by itself.
        of_model = method.__qualname__.startswith("Model.")
        shown = {k: p for k, p in options.items() if not (of_model and k == "model")}
        before = list(signature(method).parameters.values())[:-1]
        asked.__signature__ = signature(method).replace(  # type: ignore[attr-defined]
            parameters=[*before, *shown.values()]
        )
        return asked

    return cast("Taking[Asked, Query]", decorated)


def _with_bar(use_case: Callable[..., Found], *given: Any, **told: Any) -> Found:
    """What a use case finds, with a bar of its progress."""
    with interruptible(), show_progress(log=False) as report:
        return use_case(*given, **told, report=report)


def open_region(database: str | Path = "avahazard.db") -> Region:
    """Open the region of a database: a file, or an SQLAlchemy URL.

    Raises `AvahazardError` where there is no such database, or its tables are of another version.

    >>> av.open(database).paths().to_frame().shape[0]
    3
    """
    database = _database(database)
    workflow.database.database_status(database)
    return Region(database)


@dataclass(frozen=True, slots=True)
class Model:
    """A stored model of a region; `effect_files` hold the effects of its user's own.

    >>> base
    Model(database='...region.db', name='base', effect_files=())
    """

    database: str
    name: str
    effect_files: tuple[Path, ...] = ()
    _folder: Folder = field(default=None, repr=False, compare=False)

    @property
    def result(self) -> Calibration:
        """Its calibration: parameters and convergence.

        >>> base.result.parameters["a"].unit
        ''
        """
        return workflow.calibrate.show_model(self.database, self.name)

    @property
    def draws(self) -> dict[str, NDArray[np.float64]]:
        """Draws of the parameters by name, each `[n_chains, n_draws]`: `to_arviz` of ArviZ's form.

        >>> base.draws["sigma"].shape
        (2, 150)
        """
        return workflow.stored.load_parameter_draws(self.database, self.name)

    def to_arviz(self) -> Any:
        """The draws as ArviZ takes them, with its own `from_dict`.

        Raises `AvahazardError` where ArviZ is not installed.

        >>> from importlib.util import find_spec
        >>> find_spec("arviz") is None or base.to_arviz().posterior["sigma"].shape == (2, 150)
        True
        """
        try:
            arviz = import_module("arviz")
        except ImportError as error:
            raise AvahazardError(
                "ArviZ is not installed.", "Install it: pip install arviz"
            ) from error
        # From its version 1 on it takes groups by name.
        old = int(arviz.__version__.partition(".")[0]) < 1
        return arviz.from_dict(self.draws if old else {"posterior": self.draws})

    def plot_posterior(self, file: str | Path | None = None) -> Any:
        """Draw the posterior of each parameter, to `file` or to be shown by a notebook.

        >>> base.plot_posterior()
        Picture(...)
        """
        return drawn(partial(workflow.friction.plot_posterior, self.database, self._fitted()), file)

    def plot_friction(self, file: str | Path | None = None) -> Any:
        """Draw the model's friction over the volume, with the apparent friction of the events.

        >>> base.plot_friction(folder.parent / "friction.png").suffix
        '.png'
        """

        def draw(file: Path) -> None:
            request = requests.FrictionRequest(plot=file, **self._known)
            workflow.friction.show_frictions(self.database, request=request)

        return drawn(draw, file)

    def plot_residuals(self, file: str | Path | None = None) -> Any:
        """Draw the residuals of the events, in standard deviations of the model's scatter.

        Raises `AvahazardError` where fewer than three events have a volume and a friction.

        >>> base.plot_residuals()
        Picture(...)
        """
        return drawn(partial(workflow.friction.plot_residuals, self._fitted()), file)

    def compare(self) -> Comparison:
        """Hold the model against the measurements, and store that.

        Raises `AvahazardError` where the records have changed, or the method has no scatter of
        friction.

        >>> base.compare().scores.runout.coverage_90 > 0.5
        True
        """
        return _with_bar(
            workflow.compare.compare, self.database, self.name, effect_files=self.effect_files
        )

    @taking(requests.DiagnoseRequest)
    def diagnose(self, request: requests.DiagnoseRequest) -> Diagnosis:
        """Ask which effect the model lacks.

        Effects to `expect`, declared before looking, are tested first. Raises `AvahazardError`
        where the records have changed, an expected effect is no candidate, or the method cannot
        test effects.

        >>> base.diagnose().verdict in ("adequate", "missing-effect", "ambiguous")
        True
        """
        return _with_bar(workflow.diagnose.diagnose_model, self.database, self.name, request)

    def add(self, *effects: str, name: str, effect_files: Files = ()) -> Model:
        """A child of the model with more `effects`, calibrated, compared and stored as `name`.

        Raises `AvahazardError` where a name is taken, or an effect cannot be estimated from the
        records.

        >>> base.add("season", name="season").result.effects
        ('season',)
        """
        files = (*self.effect_files, *_files(effect_files))
        _with_bar(
            workflow.calibrate.add, self.database, self.name, effects, name, effect_files=files
        )
        return Model(self.database, name, files, self._folder)

    def predict(self, events: str | Path) -> Prediction:
        """Predict the stops (m) of the events of a file.

        Raises `AvahazardError` where the model cannot predict these events; `RejectedRows` for rows
        of the file that cannot be taken.

        >>> len(base.predict(folder / "events.csv").events)
        60
        """
        (file,) = _files(events)
        return workflow.compare.predict(
            self.database, self.name, file, effect_files=self.effect_files
        )

    @taking(requests.HazardRequest)
    def hazard(self, request: requests.HazardRequest) -> Hazard:
        """Runout per path, with its interval, and store that; 100 years where nothing is asked.

        It is that of `return_periods` (years) and of `volumes` (m3), from `draws` for each row;
        `source` says where the frequency of volumes comes from. Raises `AvahazardError` where no
        path has what a return period needs.

        >>> base.hazard(return_periods=100).rows[0].volume_m3 > 0.0
        True
        """
        return _with_bar(workflow.hazard.hazard, self.database, self.name, request)

    @taking(requests.ZonesRequest)
    def zones(self, request: requests.ZonesRequest) -> Zones:
        """Speed (m/s), pressure (kPa) and zones along the paths, and store them.

        The zones are those of `limits`, a preset or a TOML file, at its return periods (years) and
        `return_periods`; `density` of the flow and its standard deviation are in kg/m3. Raises
        `AvahazardError` where no path has a rate, or the method has no scatter of friction.

        >>> base.zones(paths="P01", no_drag=True).rows[0].zones[0].zone
        'red'
        """
        return _with_bar(workflow.hazard.zones, self.database, self.name, request)

    @taking(requests.RunoutRequest)
    def runout(self, path_id: str, request: requests.RunoutRequest) -> Runout:
        """Run the block down a path by this model, of the median friction of a volume or of `mu`.

        With `table` F(μ) and its derivative are there as well; `plot` is the file of a picture.
        Raises `AvahazardError` where there is no such path, or neither `mu` nor a volume over 0.

        >>> base.runout("P01", volume_m3=2e4).mu_from
        'posterior median'
        """
        return workflow.path.run_block(self.database, path_id, request)

    @taking(requests.ReportRequest)
    def report(self, file: str | Path, request: requests.ReportRequest) -> WrittenReport:
        """Write the report of the model to an HTML file, in English, German, French or Italian.

        `date` is that of the calibration where it is not given; `language` is en, de, fr or it.
        Raises `AvahazardError` where the file cannot be written, or there is no such language.

        >>> base.report(folder.parent / "base.html", title="Val d'Arly", language="fr").n_events
        60
        """
        return _with_bar(
            workflow.report.write_report, self.database, self.name, Path(file), request
        )

    def export(self, file: str | Path) -> Export:
        """Write the latest bounds and zones to a file: .gpkg, .geojson or .csv.

        Raises `AvahazardError` where no bounds are stored, or no path has coordinates for a map.

        >>> _ = base.hazard()
        >>> base.export(folder.parent / "bounds.csv").layers[0].layer
        'hazard'
        """
        return workflow.export.export(self.database, self.name, Path(file))

    def _fitted(self) -> FittedModel:
        return workflow.stored.load_stored(self.database, self.name, self.effect_files)[0]

    @property
    def _known(self) -> dict[str, Any]:
        return {"model": self.name, "effect_files": self.effect_files}


@dataclass(frozen=True, slots=True)
class Region:
    """The paths, records and models of one database.

    >>> region
    Region(database='...region.db')
    """

    database: str
    _folder: Folder = field(default=None, repr=False, compare=False)

    @classmethod
    def from_files(
        cls,
        *sources: str | Path,
        database: str | Path | None = None,
        dem: str | Path | None = None,
        land_cover: str | Path | None = None,
    ) -> Region:
        """Import `sources` (files, or folders of them) into a new database.

        Without `database` it is a temporary one, gone with the region and its models. `dem` and
        `land_cover` as in `import_files`. Raises `AvahazardError` where a source cannot be used, or
        the database is there already; `RejectedRows` for rows that cannot be taken, all of them.

        >>> av.Region.from_files(folder).paths()[0].n_events > 0
        True
        """
        folder = None
        if database is None:
            folder = TemporaryDirectory(prefix="avahazard-")
            database = Path(folder.name) / "region.db"
        database = _database(database)
        if not workflow.database.init_database(database).created:
            raise AvahazardError(
                f"{database} is there already.", "Open it with avahazard.open, or name another."
            )
        region = cls(database, folder)
        try:
            region.import_files(
                sources,
                dem=None if dem is None else Path(dem),
                land_cover=None if land_cover is None else Path(land_cover),
            )
        except BaseException:
            Path(database).unlink(missing_ok=True)
            raise
        return region

    @taking(requests.ImportRequest)
    def import_files(self, sources: Files, request: requests.ImportRequest) -> Import:
        """Import more records, from tables, folders of them, or lines on the terrain model `dem`.

        `land_cover` is a file of polygons, `crs` the system of a terrain model that names none.
        With `update` rows that contradict stored ones replace them; `dry_run` stores nothing.
        Raises `AvahazardError` where a source cannot be used; `RejectedRows` for rows that cannot
        be taken, all of them; nothing is stored.

        >>> region.import_files(folder).records.events.new
        0
        """
        return workflow.database.import_files(self.database, _files(sources), request)

    def events(self) -> Rows[Event]:
        """All recorded events, as they are stored.

        >>> region.events().to_frame()["path_id"].nunique()
        3
        """
        return Rows(workflow.stored.records_of(self.database).events)

    def profiles(self) -> Rows[Profile]:
        """The profiles of the paths: arrays of x and y (m), and what else is known of the points.

        >>> region.profiles()[0].path_id
        'P01'
        """
        return Rows(workflow.stored.records_of(self.database).profiles)

    def paths(self) -> Rows[PathSummary]:
        """All paths, with the size of their profiles (m) and what is recorded on each.

        >>> region.paths()[0].path_id
        'P01'
        """
        return workflow.listing.list_paths(self.database)

    def path(self, path_id: str) -> PathCheck:
        """One path: how its profile was regularised, and the checks of the block's assumptions.

        Raises `AvahazardError` where there is no such path or profile.

        >>> region.path("P01").fit.max_deviation_m < 10.0
        True
        """
        return workflow.path.view_path(self.database, path_id)

    def runout(
        self, path_id: str, mu: float, *, table: bool = False, plot: str | Path | None = None
    ) -> Runout:
        """Run the block of friction `mu` down a path; lengths in m, speeds in m/s.

        With `table` F(μ) and its derivative are there as well; `plot` is the file of a picture.
        Raises `AvahazardError` where there is no such path, or μ is not over 0.

        >>> region.runout("P01", 0.5).status
        'stopped'
        """
        file = None if plot is None else Path(plot)
        return workflow.path.run_block(
            self.database, path_id, requests.RunoutRequest(mu=mu, table=table, plot=file)
        )

    def friction(
        self,
        path_id: str | None = None,
        *,
        kappa: float | Literal["auto"] = 5.0,
        model: str | None = None,
        plot: str | Path | None = None,
        effect_files: Files = (),
    ) -> Frictions:
        """Apparent friction of every event, its density, and the check by perturbation.

        `kappa` is the sharpness of the density; with `model` its effects are at work. Raises
        `AvahazardError` where there are no events.

        >>> len(region.friction().events) == 60
        True
        """
        request = requests.FrictionRequest(
            kappa=kappa,
            model=model,
            plot=None if plot is None else Path(plot),
            effect_files=_files(effect_files),
        )
        return workflow.friction.show_frictions(self.database, path_id, request)

    def fit(self) -> Fits:
        """Least-squares laws of apparent friction against volume (m3).

        Raises `AvahazardError` where there are too few events.

        >>> region.fit().rows[0].law
        'exponential'
        """
        return workflow.friction.fit_laws(self.database)

    @taking(requests.VolumesRequest)
    def volumes(self, request: requests.VolumesRequest) -> Volumes:
        """How often which volume comes down each path, by return period (years).

        Raises `AvahazardError` where no path has what is needed.

        >>> region.volumes().rows[0].levels[-1].return_period_years
        300.0
        """
        return workflow.hazard.volumes(self.database, request)

    @taking(requests.HazardRequest)
    def hazard(
        self, models: str | Model | Sequence[str | Model], request: requests.HazardRequest
    ) -> Hazard:
        """Design runouts by several models, averaged; lengths in m.

        Each weighs as their mixture predicts left-out records best. Raises `AvahazardError` as
        `Model.hazard`, and where the models were calibrated on different records.

        >>> region.hazard(["base"], return_periods=100).rows[0].return_period_years
        100.0
        """
        several = [models] if isinstance(models, str | Model) else models
        names = [model.name if isinstance(model, Model) else model for model in several]
        return _with_bar(workflow.hazard.hazard, self.database, names, request)

    def alpha_beta(self, path_id: str | None = None) -> Rows[TerrainRunout]:
        """The α-β runout of one path or all, a row for each regression; angles in degrees.

        Raises `AvahazardError` where there is no such path.

        >>> region.alpha_beta("P01")[0].coefficients
        'norway'
        """
        return workflow.path.alpha_beta_paths(self.database, path_id)

    def effects(self) -> Rows[EffectEntry]:
        """The catalogue of effects, and what the present records lack for each.

        >>> region.effects()[0].key
        'centrifugal'
        """
        return workflow.effects.list_effects(self.database)

    @taking(requests.CalibrateRequest)
    def calibrate(self, name: str, request: requests.CalibrateRequest) -> Model:
        """Calibrate a model and store it as `name`; the options are those of the command.

        `with_` and `without` name effects. `prior` has mean and standard deviation by parameter,
        such as `{"a": (0.5, 0.05)}`. Raises `AvahazardError` where the name is taken, or the
        records or the method do not allow it.

        >>> region.calibrate("power", law="power", chains=2, draws=100).result.law
        'power'
        """
        _with_bar(workflow.calibrate.calibrate, self.database, name, request)
        return Model(self.database, name, _folder=self._folder)

    def model(self, name: str, effect_files: Files = ()) -> Model:
        """The stored model `name`; one with effects of the user's own needs their files again.

        Raises `AvahazardError` where there is no such model.

        >>> region.model("base").result.n_events
        60
        """
        model = Model(self.database, name, _files(effect_files), self._folder)
        _ = model.result
        return model

    def models(self) -> Rows[ModelSummary]:
        """All stored models in short, oldest first.

        >>> region.models()[0].model
        'base'
        """
        return workflow.listing.show_models(self.database)

    def ladder(self) -> Ladder:
        """Every model and its error, oldest first; those not yet compared are compared.

        Raises `AvahazardError` where there is no model.

        >>> region.ladder().rows[0].held_out_crps_m is not None
        True
        """
        return _with_bar(workflow.compare.ladder, self.database)
