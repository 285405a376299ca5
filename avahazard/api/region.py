"""A region: the paths, records and models of one database."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import avahazard.report.picture  # noqa: F401 (how results are drawn)
from avahazard.api.model import Model
from avahazard.hazard.volume_source import VolumeSource
from avahazard.inference.model.choices import (
    DEFAULT_METHOD,
    DistributionName,
    MethodName,
    ScatterName,
    TailsName,
)
from avahazard.request import many
from avahazard.results.base import Rows
from avahazard.results.database import Import
from avahazard.results.friction import Fits, Frictions
from avahazard.results.hazard import Volumes
from avahazard.results.ladder import Ladder
from avahazard.results.models import EffectEntry, ModelSummary
from avahazard.results.terrain import PathCheck, PathSummary, Runout, TerrainRunout
from avahazard.workflow.requests import RECORDS, CalibrateRequest, VolumesRequest


def open_region(database: str | Path = "avahazard.db") -> Region:
    """Open the region of a database: a file, or an SQLAlchemy URL.

    Raises:
        AvahazardError: there is no such database, or its tables are of another version.

    >>> av.open(database).paths().to_frame().shape[0]
    3
    """
    from avahazard.workflow.database import database_status  # noqa: PLC0415 (loads when used)

    database_status(str(database))
    return Region(str(database))


@dataclass(frozen=True, slots=True)
class Region:
    """The paths, records and models of one database.

    >>> region
    Region(database='...region.db')
    """

    database: str
    _folder: TemporaryDirectory[str] | None = field(default=None, repr=False, compare=False)

    @classmethod
    def from_files(
        cls,
        *sources: str | Path,
        database: str | Path | None = None,
        dem: str | Path | None = None,
        land_cover: str | Path | None = None,
    ) -> Region:
        """Import `sources` (files, or folders of them) into a new database.

        Without `database` it is a temporary one, gone with the region. `dem` and `land_cover` as
        in `import_files`.

        Raises:
            AvahazardError: a source cannot be used, or the database is there already.
            RejectedRows: rows that cannot be taken, all of them.

        >>> av.Region.from_files(folder).paths()[0].n_events > 0
        True
        """
        from avahazard.records.errors import AvahazardError  # noqa: PLC0415 (loads when used)
        from avahazard.workflow.database import init_database  # noqa: PLC0415

        folder = None
        if database is None:
            folder = TemporaryDirectory(prefix="avahazard-")
            database = Path(folder.name) / "region.db"
        if not init_database(str(database)).created:
            raise AvahazardError(
                f"{database} is there already.", "Open it with avahazard.open, or name another."
            )
        region = cls(str(database), folder)
        region.import_files(*sources, dem=dem, land_cover=land_cover)
        return region

    def import_files(
        self,
        *sources: str | Path,
        dem: str | Path | None = None,
        land_cover: str | Path | None = None,
        crs: str | None = None,
        update: bool = False,
        dry_run: bool = False,
    ) -> Import:
        """Import more records, from tables, folders of them, or lines on the terrain model `dem`.

        `land_cover` is a file of polygons, `crs` the system of a terrain model that names none.
        With `update` rows that contradict stored ones replace them; `dry_run` stores nothing.

        Raises:
            AvahazardError: a source cannot be used.
            RejectedRows: rows that cannot be taken, all of them; nothing is stored.

        >>> region.import_files(folder).records.events.new
        0
        """
        from avahazard.workflow.import_files import import_files  # noqa: PLC0415

        return import_files(
            self.database,
            sources,
            dem=dem,
            land_cover=land_cover,
            crs=crs,
            update=update,
            dry_run=dry_run,
        )

    def paths(self) -> Rows[PathSummary]:
        """All paths, with the size of their profiles (m) and what is recorded on each.

        >>> region.paths()[0].path_id
        'P01'
        """
        from avahazard.workflow.path import list_paths  # noqa: PLC0415

        return list_paths(self.database)

    def path(self, path_id: str) -> PathCheck:
        """One path: how its profile was regularised, and the checks of the block's assumptions.

        Raises `AvahazardError` where there is no such path or profile.

        >>> region.path("P01").fit.max_deviation_m < 10.0
        True
        """
        from avahazard.workflow.path import view_path  # noqa: PLC0415

        return view_path(self.database, path_id)

    def runout(
        self,
        path_id: str,
        mu: float,
        *,
        table: bool = False,
        plot: str | Path | None = None,
    ) -> Runout:
        """Run the block of friction `mu` down a path; lengths in m, speeds in m/s.

        With `table` F(μ) and its derivative are there as well; `plot` is the file of a picture.
        Raises `AvahazardError` where there is no such path, or μ is not over 0.

        >>> region.runout("P01", 0.5).status
        'stopped'
        """
        from avahazard.workflow.runout import run_path  # noqa: PLC0415

        file = None if plot is None else Path(plot)
        return run_path(self.database, path_id, mu, table=table, plot=file)

    def friction(
        self,
        path_id: str | None = None,
        *,
        kappa: float | Literal["auto"] = 5.0,
        model: str | None = None,
        plot: str | Path | None = None,
        effect_files: Sequence[str | Path] = (),
    ) -> Frictions:
        """Apparent friction of every event, its density, and the check by perturbation.

        `kappa` is the sharpness of the density; with `model` its effects are at work. Raises
        `AvahazardError` where there are no events.

        >>> len(region.friction().events) == 60
        True
        """
        from avahazard.workflow.friction import show_frictions  # noqa: PLC0415

        return show_frictions(
            self.database,
            path_id,
            kappa,
            None if plot is None else Path(plot),
            model,
            [Path(file) for file in effect_files],
        )

    def fit(self) -> Fits:
        """Least-squares laws of apparent friction against volume (m3).

        Raises `AvahazardError` where there are too few events.

        >>> region.fit().rows[0].law
        'exponential'
        """
        from avahazard.workflow.friction import fit_laws  # noqa: PLC0415

        return fit_laws(self.database)

    def volumes(
        self,
        *,
        paths: Sequence[str] = (),
        return_periods: Sequence[float] | float = (),
        source: VolumeSource = RECORDS,
        plot: str | Path | None = None,
        seed: int = 0,
    ) -> Volumes:
        """How often which volume comes down each path, by return period (years).

        Raises `AvahazardError` where no path has what is needed.

        >>> region.volumes().rows[0].levels[-1].return_period_years
        300.0
        """
        from avahazard.workflow.volumes import volumes  # noqa: PLC0415

        request = VolumesRequest(
            return_periods=many(return_periods),
            source=source,
            plot=None if plot is None else Path(plot),
            seed=seed,
        )
        return volumes(self.database, many(paths), request)

    def alpha_beta(self, path_id: str | None = None, by: Sequence[str] = ()) -> Rows[TerrainRunout]:
        """The α-β runout of one path or all, a row for each regression; angles in degrees.

        `by` names the regressions. Raises `AvahazardError` where there is no such path.

        >>> region.alpha_beta("P01")[0].coefficients
        'norway'
        """
        from avahazard.workflow.alpha_beta import alpha_beta_paths  # noqa: PLC0415

        return alpha_beta_paths(self.database, path_id, by=many(by))

    def effects(self) -> Rows[EffectEntry]:
        """The catalogue of effects, and what the present records lack for each.

        >>> region.effects()[0].key
        'centrifugal'
        """
        from avahazard.workflow.effects import list_effects  # noqa: PLC0415

        return list_effects(self.database)

    def calibrate(
        self,
        name: str,
        *,
        law: str = "exponential",
        scatter: ScatterName = "constant",
        distribution: DistributionName = "lognormal",
        method: MethodName = DEFAULT_METHOD,
        tails: TailsName = "normal",
        with_: Sequence[str] = (),
        without: Sequence[str] = (),
        paths: Sequence[str] = (),
        prior_from: str | None = None,
        prior: Mapping[str, tuple[float, float]] | None = None,
        chains: int = 4,
        draws: int | None = None,
        seed: int = 0,
    ) -> Model:
        """Calibrate a model and store it as `name`; the options are those of the command.

        `with_` and `without` name effects. `prior` has mean and standard deviation by parameter,
        such as `{"a": (0.5, 0.05)}`.

        Raises:
            AvahazardError: the name is taken, or the records or the method do not allow it.

        >>> region.calibrate("power", law="power", chains=2, draws=100).result.law
        'power'
        """
        from avahazard.workflow.calibrate import calibrate  # noqa: PLC0415

        request = CalibrateRequest(
            law=law,
            scatter=scatter,
            distribution=distribution,
            method=method,
            tails=tails,
            with_=with_,
            without=without,
            paths=paths,
            prior_from=prior_from,
            prior=prior or {},
            chains=chains,
            draws=draws,
            seed=seed,
        )
        calibrate(self.database, name, request)
        return Model(self.database, name)

    def model(self, name: str, effect_files: Sequence[str | Path] = ()) -> Model:
        """The stored model `name`; one with effects of the user's own needs their files again.

        Raises `AvahazardError` where there is no such model.

        >>> region.model("base").result.n_events
        60
        """
        model = Model(self.database, name, tuple(Path(file) for file in effect_files))
        _ = model.result
        return model

    def models(self) -> Rows[ModelSummary]:
        """All stored models in short, oldest first.

        >>> region.models()[0].model
        'base'
        """
        from avahazard.workflow.models import show_models  # noqa: PLC0415

        return show_models(self.database)

    def ladder(self) -> Ladder:
        """Every model and its error, oldest first; those not yet compared are compared.

        Raises `AvahazardError` where there is no model.

        >>> region.ladder().rows[0].held_out_crps_m is not None
        True
        """
        from avahazard.workflow.compare import ladder  # noqa: PLC0415

        return ladder(self.database)
