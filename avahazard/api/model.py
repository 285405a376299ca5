"""A stored model, and what can be asked of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import avahazard.report.picture  # noqa: F401 (how results are drawn)
from avahazard.hazard.volume_source import VolumeSource
from avahazard.report.language import LanguageName
from avahazard.request import many
from avahazard.results.calibration import Calibration
from avahazard.results.comparison import Comparison
from avahazard.results.database import Export, WrittenReport
from avahazard.results.diagnosis import Diagnosis
from avahazard.results.hazard import Hazard
from avahazard.results.prediction import Prediction
from avahazard.results.terrain import Runout
from avahazard.results.zones import Zones
from avahazard.workflow.requests import (
    RECORDS,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
    ZonesRequest,
)


@dataclass(frozen=True, slots=True)
class Model:
    """A stored model of a region; `effect_files` hold the effects of its user's own.

    >>> base
    Model(database='...region.db', name='base', effect_files=())
    """

    database: str
    name: str
    effect_files: tuple[Path, ...] = ()

    @property
    def result(self) -> Calibration:
        """Its calibration: parameters and convergence.

        >>> base.result.parameters["a"].unit
        ''
        """
        from avahazard.workflow.models import show_model  # noqa: PLC0415 (loads when used)

        return show_model(self.database, self.name)

    @property
    def draws(self) -> dict[str, NDArray[np.float64]]:
        """Draws of the parameters by name, each `[n_chains, n_draws]`.

        ArviZ reads this form: `arviz.from_dict({"posterior": model.draws})`.

        >>> base.draws["sigma"].shape
        (2, 150)
        """
        from avahazard.workflow.stored import load_parameter_draws  # noqa: PLC0415

        return load_parameter_draws(self.database, self.name)

    def compare(self) -> Comparison:
        """Hold the model against the measurements, and store that.

        Raises:
            AvahazardError: the records have changed, or the method has no scatter of friction.

        >>> base.compare().scores.runout.coverage_90 > 0.5
        True
        """
        from avahazard.workflow.compare import compare  # noqa: PLC0415

        return compare(self.database, self.name, effect_files=self.effect_files)

    def diagnose(
        self, *, expect: Sequence[str] = (), worlds: int = 199, seed: int = 0
    ) -> Diagnosis:
        """Ask which effect the model lacks, against `worlds` made from it.

        Effects to `expect`, declared before looking, are tested first.

        Raises:
            AvahazardError: the records have changed, an expected effect is no candidate, or the
                method cannot test effects.

        >>> base.diagnose(worlds=39).verdict in ("adequate", "missing-effect", "ambiguous")
        True
        """
        from avahazard.workflow.diagnose import diagnose_model  # noqa: PLC0415

        request = DiagnoseRequest(
            expect=expect, worlds=worlds, seed=seed, effect_files=self.effect_files
        )
        return diagnose_model(self.database, self.name, request)

    def add(self, *effects: str, name: str, effect_files: Sequence[str | Path] = ()) -> Model:
        """A child of the model with more `effects`, calibrated, compared and stored as `name`.

        Raises:
            AvahazardError: a name is taken, or an effect cannot be told from the records.

        >>> base.add("season", name="season").result.effects
        ('season',)
        """
        from avahazard.workflow.add import add  # noqa: PLC0415

        files = (*self.effect_files, *(Path(file) for file in effect_files))
        add(self.database, self.name, effects, name, effect_files=files)
        return Model(self.database, name, files)

    def predict(self, events: str | Path) -> Prediction:
        """Predict the stops (m) of the events of a file.

        Raises:
            AvahazardError: the model cannot predict these events.
            RejectedRows: rows of the file that cannot be taken.

        >>> len(base.predict(folder / "events.csv").events)
        60
        """
        from avahazard.workflow.predict import predict  # noqa: PLC0415

        return predict(self.database, self.name, Path(events), effect_files=self.effect_files)

    def hazard(
        self,
        *,
        return_periods: Sequence[float] | float = (),
        volumes: Sequence[float] | float = (),
        paths: Sequence[str] = (),
        source: VolumeSource = RECORDS,
        draws: int = 20_000,
        seed: int = 0,
    ) -> Hazard:
        """Runout per path, with its interval, and store that; 100 years where nothing is asked.

        It is that of `return_periods` (years) and of `volumes` (m3), from `draws` for each row;
        `source` says where the frequency of volumes comes from.

        Raises:
            AvahazardError: no path has what a return period needs.

        >>> base.hazard(return_periods=100).rows[0].volume_m3 > 0.0
        True
        """
        from avahazard.workflow.hazard import hazard  # noqa: PLC0415

        request = HazardRequest(
            return_periods=many(return_periods),
            volumes=many(volumes),
            paths=paths,
            source=source,
            draws=draws,
            seed=seed,
            effect_files=self.effect_files,
        )
        return hazard(self.database, self.name, request)

    def zones(
        self,
        *,
        return_periods: Sequence[float] | float = (),
        limits: str = "swiss",
        paths: Sequence[str] = (),
        source: VolumeSource = RECORDS,
        density: float = 300.0,
        density_sd: float = 50.0,
        plot: str | Path | None = None,
        seed: int = 0,
    ) -> Zones:
        """Speed (m/s), pressure (kPa) and zones along the paths, and store them.

        The zones are those of `limits`, a preset or a TOML file, at its return periods (years) and
        `return_periods`; `density` of the flow and its standard deviation are in kg/m3.

        Raises:
            AvahazardError: no path has a rate, or the method has no scatter of friction.

        >>> base.zones(paths="P01").rows[0].zones[0].zone
        'red'
        """
        from avahazard.workflow.zones import zones  # noqa: PLC0415

        request = ZonesRequest(
            return_periods=many(return_periods),
            limits=limits,
            paths=paths,
            source=source,
            density=density,
            density_sd=density_sd,
            plot=None if plot is None else Path(plot),
            seed=seed,
            effect_files=self.effect_files,
        )
        return zones(self.database, self.name, request)

    def runout(
        self,
        path_id: str,
        *,
        volume_m3: float | None = None,
        mu: float | None = None,
        table: bool = False,
        plot: str | Path | None = None,
    ) -> Runout:
        """Run the block down a path by this model, of the median friction of a volume or of `mu`.

        With `table` F(μ) and its derivative are there as well; `plot` is the file of a picture.

        Raises:
            AvahazardError: there is no such path, or neither `mu` nor a volume over 0.

        >>> base.runout("P01", volume_m3=2e4).mu_from
        'posterior median'
        """
        from avahazard.workflow.runout import run_model  # noqa: PLC0415

        return run_model(
            self.database,
            path_id,
            self.name,
            volume_m3=volume_m3,
            mu=mu,
            table=table,
            plot=None if plot is None else Path(plot),
            effect_files=self.effect_files,
        )

    def report(
        self,
        file: str | Path,
        *,
        title: str = "",
        author: str = "",
        place: str = "",
        date: str = "",
        language: LanguageName = "en",
    ) -> WrittenReport:
        """Write the report of the model to an HTML file, in English, German, French or Italian.

        `date` is that of the calibration where it is not given; `language` is en, de, fr or it.

        Raises:
            AvahazardError: the file cannot be written, or there is no such language.

        >>> base.report(folder.parent / "base.html", title="Val d'Arly", language="fr").n_events
        60
        """
        from avahazard.workflow.report import write_report  # noqa: PLC0415

        request = ReportRequest(
            title=title,
            author=author,
            place=place,
            date=date,
            language=language,
            effect_files=self.effect_files,
        )
        return write_report(self.database, self.name, Path(file), request)

    def export(self, file: str | Path) -> Export:
        """Write the latest bounds and zones to a file: .gpkg, .geojson or .csv.

        Raises:
            AvahazardError: no bounds are stored, or no path has coordinates for a map.

        >>> _ = base.hazard()
        >>> base.export(folder.parent / "bounds.csv").layers[0].layer
        'hazard'
        """
        from avahazard.workflow.export import export  # noqa: PLC0415

        return export(self.database, self.name, Path(file))
