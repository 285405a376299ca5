"""The file of a project, `avahazard.toml`: which records, which model, which answers."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated, Literal

from pydantic import Field

from avahazard.inference.model.specification import (
    DistributionName,
    MethodName,
    ScatterName,
    TailsName,
)
from avahazard.records.errors import AvahazardError
from avahazard.records.toml_document import Strict, read_toml
from avahazard.report.language import LanguageName

NAME = "avahazard.toml"
EXAMPLE = (
    'The least is: files = ["records"], the folder of paths.csv, profiles.csv and events.csv. '
    "docs/project.md has all keys."
)
StepName = Literal["compare", "diagnose", "hazard", "zones", "report", "export"]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Years = Annotated[float, Field(gt=1.0, allow_inf_nan=False)]
MeanSd = Annotated[list[float], Field(min_length=2, max_length=2)]
Name = Annotated[str, Field(min_length=1, max_length=150)]


class ProjectSection(Strict):
    """`[project]`: what the document is called, who answers for it, and of which place it is."""

    title: str = ""
    author: str = ""
    place: str = ""
    date: str = ""
    language: LanguageName = "en"


class ModelSection(Strict):
    """`[model]`: what `calibrate` is asked for."""

    name: Name = "base"
    law: str = "exponential"
    scatter: ScatterName = "constant"
    distribution: DistributionName = "lognormal"
    method: MethodName = "marginal"
    tails: TailsName = "normal"
    with_: list[str] = Field(default=[], alias="with")
    without: list[str] = Field(default=[])
    paths: list[str] = Field(default=[])
    prior_from: str = ""
    prior: dict[str, MeanSd] = Field(default={})
    chains: Annotated[int, Field(ge=2, le=64)] | None = None
    draws: Annotated[int, Field(ge=50)] | None = None
    seed: Annotated[int, Field(ge=0)] = 0


class DiagnoseSection(Strict):
    """`[diagnose]`: how many worlds are made, and whether what is named is added."""

    worlds: Annotated[int, Field(ge=39, le=9999)] = 199
    seed: Annotated[int, Field(ge=0)] = 0
    add: bool = False
    rounds: Annotated[int, Field(ge=1, le=9)] = 3


class HazardSection(Strict):
    """`[hazard]`: return periods (years) and volumes (m3)."""

    return_periods: list[Years] = Field(default=[100.0])
    volumes: list[Positive] = Field(default=[])
    paths: list[str] = Field(default=[])
    seed: Annotated[int, Field(ge=0)] = 0


class ZonesSection(Strict):
    """`[zones]`: a preset, or a file of limits."""

    limits: str = "swiss"


class ReportSection(Strict):
    """`[report]`: the page to write."""

    file: str = "report.html"


class ExportSection(Strict):
    """`[export]`: the files to write, each for what its name ends in."""

    files: list[str] = Field(default=["bounds.csv"])


class Project(Strict):
    """A whole project; files are beside `avahazard.toml` unless they are absolute."""

    files: Annotated[list[str], Field(min_length=1)]
    database: str | None = None
    update: bool = False
    unusual: bool = False
    dem: str | None = None
    land_cover: str | None = None
    skip: list[StepName] = Field(default=[])
    project: ProjectSection = ProjectSection()
    model: ModelSection = ModelSection()
    diagnose: DiagnoseSection = DiagnoseSection()
    hazard: HazardSection = HazardSection()
    zones: ZonesSection = ZonesSection()
    report: ReportSection = ReportSection()
    export: ExportSection = ExportSection()


def read_project(file: FilePath) -> Project:
    """Read the file of a project.

    Raises:
        AvahazardError: there is no such file, or a value is missing, unknown or out of range.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise AvahazardError(
            f"The project {file} cannot be read: {error.strerror}.",
            f"Write {NAME} in this folder, or name another: avahazard run FILE. {EXAMPLE}",
        ) from error
    except UnicodeDecodeError as error:
        raise AvahazardError(f"{file} is not UTF-8.", "Save it as UTF-8.") from error
    return read_toml(str(file), text, Project, EXAMPLE)
