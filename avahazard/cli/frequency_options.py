"""Options that say where the frequency of volumes comes from; several commands have them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from avahazard.workflow.frequencies import VolumeSource


class FamilyName(StrEnum):
    """How the volumes of the records are fitted."""

    gev = "gev"
    gpd = "gpd"


FrequencyOption = Annotated[
    FamilyName,
    typer.Option(help="gev of the yearly largest volumes, or gpd of those over a threshold."),
]
ThresholdOption = Annotated[
    float | None,
    typer.Option(
        metavar="M3",
        help="The threshold of gpd. [default: the median of each path's volumes]",
        show_default=False,
    ),
]
TableOption = Annotated[
    Path | None,
    typer.Option(
        "--volumes",
        metavar="FILE",
        help="Your own volumes: CSV with path_id, return_period_years, volume_m3.",
    ),
]
SnowfallOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Volumes from three-day snow depths over release_area_m2 of the path: CSV with "
        "year, depth_m, and path_id where they differ.",
    ),
]
DensityOption = Annotated[
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
    from avahazard.workflow.frequencies import VolumeSource  # noqa: PLC0415

    if table is not None and snowfall is not None:
        raise typer.BadParameter("--volumes and --snowfall exclude each other.")
    if threshold is not None and frequency is not FamilyName.gpd:
        raise typer.BadParameter("--threshold is for --frequency gpd.")
    return VolumeSource(frequency.value, threshold, table, snowfall, density_ratio)
