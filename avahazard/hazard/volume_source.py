"""Where the frequency of volumes comes from."""

from pathlib import Path as FilePath
from typing import Literal

from avahazard.records.collection import WINTER_STARTS
from avahazard.records.errors import AvahazardError
from avahazard.request import Request, option

Family = Literal["gev", "gpd"]


class VolumeSource(Request):
    """Where the frequency of volumes comes from: records, or a table of the user's.

    A year begins in month `year_starts`. Rate and volumes are means over the observed years or, by
    the trend of the records, those of the year `as_of`.
    `family` is `gev` of yearly maxima or `gpd` over a threshold (m3; without one, the median of
    each path's volumes). `table` holds (T, V) of the user's.
    """

    family: Family = option(
        "gev",
        "gev of the yearly largest volumes, or gpd of those over a threshold.",
        flag="--frequency",
        what="family of frequencies",
    )
    threshold_m3: float | None = option(
        None,
        "The threshold of gpd. [default: the median of each path's volumes]",
        flag="--threshold",
        what="threshold",
        unit="m3",
        over=0.0,
    )
    table: FilePath | None = option(
        None,
        "Your own volumes: CSV with path_id, return_period_years, volume_m3.",
        flag="--volumes",
    )
    year_starts: int = option(
        WINTER_STARTS,
        "Month in which a year begins: 10 for winters, 1 for calendar years.",
        metavar="MONTH",
        what="month",
        least=1,
        most=12,
    )
    as_of: int | None = option(
        None,
        "Rate and volumes of this year, by the trend of the records. [default: means over "
        "the observed years]",
        metavar="YEAR",
        what="year",
        least=1000,
        most=3000,
    )

    def check(self) -> None:
        """Raise `AvahazardError` for values that do not go together."""
        if self.as_of is not None and self.table is not None:
            raise AvahazardError("--as-of is for volumes from records.")
        if self.threshold_m3 is not None and self.family != "gpd":
            raise AvahazardError("--threshold is for --frequency gpd.")
