"""Arguments and options that several commands have."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from avahazard.hazard.frequencies import VolumeSource


StoredModel = Annotated[str, typer.Argument(help="A stored model.", show_default=False)]
CalibratedModel = Annotated[str, typer.Argument(help="A calibrated model.", show_default=False)]
OnePath = Annotated[str, typer.Argument(help="The path_id of a path.", show_default=False)]
OnlyPaths = Annotated[
    list[str] | None, typer.Option(metavar="PATH", help="Only this path; may be given again.")
]
Seed = Annotated[int, typer.Option(min=0, max=2**62, help="Equal seeds, equal draws.")]
EffectFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--effect-file",
        metavar="FILE",
        help="The file of an effect of your own that the model has; may be given again.",
    ),
]


def picture(what: str = "Write a picture") -> Any:
    """The option of a picture: `what` it shows."""
    return typer.Option(metavar="FILE", help=f"{what}: .png, .svg or .pdf.")


def positive(value: float | None) -> float | None:
    """The value of an option that must be a number over 0."""
    return _over(0.0, value)


def all_over(least: float) -> Callable[[list[float] | None], list[float] | None]:
    """What checks an option that may be given again: each is to be a number over the least."""

    def check(values: list[float] | None) -> list[float] | None:
        for value in values or ():
            _over(least, value)
        return values

    return check


def _over(least: float, value: float | None) -> float | None:
    if value is not None and not (isfinite(value) and value > least):
        raise typer.BadParameter(f"{value:g} will not do, it must be a number over {least:g}")
    return value


def return_periods(words: str) -> Any:
    """The option of return periods: what holds besides or without it."""
    return typer.Option(
        "-T", "--return-period", metavar="YEARS", help=words, show_default=False,
        callback=all_over(1.0),
    )  # fmt: skip


def output_file(words: str) -> Any:
    """The option of the file to write: what it may be."""
    return typer.Option("-o", "--output", metavar="FILE", help=words, show_default=False)


class ReportLanguage(StrEnum):
    """Languages of the report."""

    en = "en"
    de = "de"
    fr = "fr"
    it = "it"


class FamilyName(StrEnum):
    """How the volumes of the records are fitted."""

    gev = "gev"
    gpd = "gpd"


Frequency = Annotated[
    FamilyName,
    typer.Option(help="gev of the yearly largest volumes, or gpd of those over a threshold."),
]
Threshold = Annotated[
    float | None,
    typer.Option(
        metavar="M3",
        help="The threshold of gpd. [default: the median of each path's volumes]",
        show_default=False,
    ),
]
VolumeTable = Annotated[
    Path | None,
    typer.Option(
        "--volumes",
        metavar="FILE",
        help="Your own volumes: CSV with path_id, return_period_years, volume_m3.",
    ),
]
Snowfall = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Volumes from three-day snow depths over release_area_m2 of the path: CSV with "
        "year, depth_m, and path_id where they differ.",
    ),
]
DensityRatio = Annotated[
    float,
    typer.Option(
        metavar="RATIO",
        help="With --snowfall: density of the released snow over that of the deposit.",
    ),
]


def volume_source(
    frequency: FamilyName,
    threshold: float | None,
    table: Path | None,
    snowfall: Path | None,
    density_ratio: float,
) -> VolumeSource:
    """What the options say; wrong usage where they contradict each other."""
    from avahazard.hazard.frequencies import VolumeSource  # noqa: PLC0415

    if table is not None and snowfall is not None:
        raise typer.BadParameter("--volumes and --snowfall exclude each other.")
    if threshold is not None and frequency is not FamilyName.gpd:
        raise typer.BadParameter("--threshold is for --frequency gpd.")
    return VolumeSource(frequency.value, threshold, table, snowfall, density_ratio)
