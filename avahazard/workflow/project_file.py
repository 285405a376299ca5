"""The file of a project, `avahazard.toml`: which records, which model, which answers."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, get_type_hints

from pydantic import Field as Limits
from pydantic import create_model
from pydantic_core.core_schema import no_info_after_validator_function

from avahazard.records.errors import AvahazardError
from avahazard.records.toml_document import Strict, read_toml
from avahazard.request import Field, Request, fields_of
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
    ZonesRequest,
)

NAME = "avahazard.toml"
EXAMPLE = (
    'The least is: files = ["records"], the folder of paths.csv, profiles.csv and events.csv. '
    "docs/project.md has all keys."
)
StepName = Literal["compare", "diagnose", "hazard", "zones", "report", "export"]
Pair = Annotated[list[float], Limits(min_length=2, max_length=2)]
Name = Annotated[str, Limits(min_length=1, max_length=150)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelRequest(CalibrateRequest):
    """`[model]`: what `calibrate` is asked for, and the name of the model."""

    name: Name = "base"


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundsRequest(DiagnoseRequest):
    """`[diagnose]`: what `diagnose` is asked for, and how often what it names is added."""

    add: bool = False
    rounds: Annotated[int, Limits(ge=1, le=9)] = 3


@dataclass(frozen=True, slots=True)
class Table:
    """A table of the file: `keys` of a request, which is `base` where they are not given."""

    base: Request
    keys: tuple[str, ...]

    def __get_pydantic_core_schema__(self, request: Any, handler: Any) -> Any:
        told: dict[str, Any] = {
            key: (hint, None)
            for key, hint in get_type_hints(request, include_extras=True).items()
            if key in self.keys
        }
        told |= {f.name: (_value(f), None) for f in fields_of(request) if f.name in self.keys}
        form = create_model(request.__name__, __base__=Strict, **told)
        return no_info_after_validator_function(
            lambda read: replace(self.base, **{k: getattr(read, k) for k in read.model_fields_set}),
            handler.generate_schema(form),
        )


def _value(field: Field) -> Any:
    """The type of a key, with its limits and its name in the file."""
    option = field.option
    kind = field.kind if option.parse is None else dict[str, Pair]
    if kind in (int, float):
        within = Limits(gt=option.over, ge=option.least, le=option.most, allow_inf_nan=False)
        kind = Annotated[kind, within]
    kind = list[kind] if field.many else kind  # type: ignore[valid-type]
    return Annotated[kind, Limits(alias=field.name.rstrip("_"))]


MODEL = tuple(field.name for field in fields(ModelRequest))
YEARS = (100.0,)


class ReportSection(Strict):
    """`[report]`: the page to write."""

    file: str = "report.html"


class ExportSection(Strict):
    """`[export]`: the files to write, each for what its name ends in."""

    files: list[str] = Limits(default=["bounds.csv"])


class Project(Strict):
    """A whole project; files are beside `avahazard.toml` unless they are absolute."""

    files: Annotated[list[str], Limits(min_length=1)]
    database: str | None = None
    update: bool = False
    unusual: bool = False
    dem: str | None = None
    land_cover: str | None = None
    skip: list[StepName] = Limits(default=[])
    project: Annotated[
        ReportRequest, Table(ReportRequest(), ("title", "author", "place", "date", "language"))
    ] = ReportRequest()
    model: Annotated[ModelRequest, Table(ModelRequest(), MODEL)] = ModelRequest()
    diagnose: Annotated[
        RoundsRequest, Table(RoundsRequest(), ("worlds", "seed", "add", "rounds"))
    ] = RoundsRequest()
    hazard: Annotated[
        HazardRequest,
        Table(HazardRequest(return_periods=YEARS), ("return_periods", "volumes", "paths", "seed")),
    ] = HazardRequest(return_periods=YEARS)
    zones: Annotated[ZonesRequest, Table(ZonesRequest(), ("limits",))] = ZonesRequest()
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
