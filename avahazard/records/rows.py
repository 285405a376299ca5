"""The forms of a row of each file (docs/data_forms.md), and the check of a table row by row."""

import datetime as dt
from collections.abc import Iterable, Iterator
from typing import Annotated, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic_core import PydanticCustomError

from avahazard.records.conventions import ACCEPTED, ISO, NO_SUCH_DAY
from avahazard.records.errors import Problems, RowProblem
from avahazard.records.meanings import MEANINGS


def _plain_number(text: str) -> str:
    """Refuse what Python reads as a number but a table does not mean as one, such as 1_000."""
    if "_" in text:
        raise ValueError(text)
    return text


def _plain_flag(text: str) -> str:
    """Take 0.0 and 1.0 too: so writes a table program a column with empty cells."""
    return {"0.0": "0", "1.0": "1"}.get(text, text)


PLAIN = BeforeValidator(_plain_number)
Name = Annotated[str, Field(min_length=1, max_length=200)]
Number = Annotated[float, Field(allow_inf_nan=False), PLAIN]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), PLAIN]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), PLAIN]
Year = Annotated[int, Field(ge=1, le=9999), PLAIN]
Flag = Annotated[bool, BeforeValidator(_plain_flag)]

ID = "an identifier of 1 to 200 characters"
ELEVATION = "an elevation in metres above sea level"


class Row(BaseModel):
    """One row of a file; a field's description is what would be accepted there."""

    model_config = ConfigDict(extra="ignore", frozen=True)


R = TypeVar("R", bound=Row)


def wrong(column: str, accepted: str) -> PydanticCustomError:
    """Build the error of a check over several columns, shown at `column`."""
    return PydanticCustomError("row", "row", {"column": column, "accepted": accepted})


def check_rows(
    form: type[R],
    file: str,
    rows: Iterable[tuple[int, dict[str, str]]],
    problems: Problems,
    context: dict[str, bool] | None = None,
) -> Iterator[tuple[int, R]]:
    """Yield the rows that keep to `form`; add the others' faults to `problems`."""
    for line, cells in rows:
        try:
            yield line, form.model_validate(cells, context=context)
        except ValidationError as error:
            for fault in error.errors(include_url=False):
                if fault["type"] == "row":
                    column, accepted = fault["ctx"]["column"], fault["ctx"]["accepted"]
                else:
                    column = str(fault["loc"][0])
                    accepted = form.model_fields[column].description or ""
                problems.append(RowProblem(file, line, column, cells.get(column, ""), accepted))


YEAR = "a year"


class PathRow(Row):
    """What is known of a path apart from its profile."""

    path_id: Name = Field(description=ID)
    name: str | None = Field(None, description="text")
    location: str | None = Field(None, description="text")
    orientation: str | None = Field(None, description="text")
    section: Literal["channelled", "open"] | None = Field(
        None, description="channelled or open, or empty"
    )
    catchment_ha: NotNegative | None = Field(None, description="an area in hectares, not negative")
    release_elevation_m: Number | None = Field(None, description=ELEVATION)
    observed_from: Year | None = Field(None, description=YEAR)
    observed_to: Year | None = Field(None, description=YEAR)
    observed_below_m: Number | None = Field(None, description=ELEVATION)

    @model_validator(mode="after")
    def _years_in_order(self) -> Self:
        first, last = self.observed_from, self.observed_to
        if first is not None and last is not None and first > last:
            raise wrong("observed_from", f"a year not after observed_to, which is {last}")
        return self


Longitude = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False), PLAIN]
Latitude = Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False), PLAIN]


class PointRow(Row):
    """A row that may have a place on the map."""

    easting_m: Number | None = Field(None, description="a map coordinate in metres")
    northing_m: Number | None = Field(None, description="a map coordinate in metres")
    crs: Name | None = Field(None, description="a coordinate system such as EPSG:31287")
    lon: Longitude | None = Field(None, description="degrees from -180 to 180")
    lat: Latitude | None = Field(None, description="degrees from -90 to 90")

    @model_validator(mode="after")
    def _coordinates_in_pairs(self) -> Self:
        for first, second in (("easting_m", "northing_m"), ("lon", "lat")):
            missing = [name for name in (first, second) if getattr(self, name) is None]
            if len(missing) == 1:
                raise wrong(missing[0], f"{first} and {second}, both or neither")
        return self


class ProfileRow(PointRow):
    """One point of a profile."""

    path_id: Name = Field(description=ID)
    x_m: Number = Field(description="the horizontal distance from the top of the path in metres")
    y_m: Number = Field(description=ELEVATION)
    land_cover: Name | None = Field(None, description="a word such as open or forest")
    elevation_sigma_m: Positive | None = Field(
        None, description="the error of the elevation in metres, above 0"
    )


LENGTH = "metres, over 0"


def _iso_date(text: str) -> str:
    if not ISO.fullmatch(text):
        raise ValueError(text)
    try:
        dt.date.fromisoformat(text if len(text) > len("1950") else f"{text}-01-01")
    except ValueError:
        raise wrong("date", NO_SUCH_DAY) from None
    return text


Date = Annotated[str, AfterValidator(_iso_date)]


class DepositRow(Row):
    """An event without its place: the two forms of an event build on it."""

    event_id: Name = Field(description=ID)
    date: Date | None = Field(None, description=ACCEPTED)
    runout_sigma_m: Positive | None = Field(None, description=LENGTH)
    release_elevation_m: Number | None = Field(None, description=ELEVATION)
    volume_m3: Positive | None = Field(None, description="a volume in m3, over 0")
    deposit_length_m: Positive | None = Field(None, description=LENGTH)
    deposit_width_m: Positive | None = Field(None, description=LENGTH)
    deposit_thickness_m: Positive | None = Field(None, description=LENGTH)
    volume_rel_sigma: NotNegative | None = Field(
        None, description="the standard deviation of the log of the volume, not negative"
    )

    @model_validator(mode="after")
    def _deposit_complete(self) -> Self:
        # A length alone is a measurement of its own (the leading edge); a width or a
        # thickness alone was meant for the volume.
        sides = ("deposit_length_m", "deposit_width_m", "deposit_thickness_m")
        missing = [name for name in sides if getattr(self, name) is None]
        alone = missing == list(sides[1:])
        if self.volume_m3 is None and 0 < len(missing) < 3 and not alone:
            raise wrong(missing[0], "length, width and thickness of the deposit, or volume_m3")
        return self


class EventRow(DepositRow, PointRow):
    """An event on a path: its stop is a place along the profile, beyond its end, or a point."""

    path_id: Name = Field(
        description="the path_id of a path, or fall_height_m and runout_length_m instead, "
        "or h_over_l"
    )
    runout_elevation_m: Number | None = Field(None, description=ELEVATION)
    runout_x_m: Number | None = Field(None, description="the distance along the profile in metres")
    left_profile: Flag = Field(False, description="0 or 1")
    fall_height_m: None = Field(None, description="empty, because path_id is given")
    runout_length_m: None = Field(None, description="empty, because path_id is given")
    h_over_l: None = Field(None, description="empty, because path_id is given")

    @property
    def point(self) -> str:
        """The first coordinate of the stop, where that is known as a point alone; else empty."""
        if self.runout_x_m is not None or self.runout_elevation_m is not None or self.left_profile:
            return ""
        given = (name for name in ("lon", "easting_m") if getattr(self, name) is not None)
        return next(given, "")

    @model_validator(mode="after")
    def _runout_given(self, info: ValidationInfo) -> Self:
        needed = (info.context or {}).get("need_runout", True)
        known = self.runout_x_m is not None or self.runout_elevation_m is not None
        if needed and not (known or self.left_profile or self.point):
            raise wrong("runout_x_m", "runout_x_m or runout_elevation_m, or left_profile 1")
        return self


WITHOUT_PATH = "empty, or a path_id with it"
# Given twice, they may differ by the rounding of a table.
ROUNDING = 0.05


class StraightRow(DepositRow):
    """An event on the straight line from release to stop: apparent friction H/L.

    H is also the release less the stop, or H/L times L; L is also H over H/L. H/L alone is enough
    too: the event then has neither H nor L.
    """

    fall_height_m: Positive | None = Field(None, description="the height of fall H in m, over 0")
    runout_length_m: Positive | None = Field(
        None, description="the horizontal reach L in metres, over 0"
    )
    h_over_l: Positive | None = Field(None, description="H over L, over 0")
    runout_elevation_m: Number | None = Field(None, description=ELEVATION)
    runout_x_m: None = Field(None, description=WITHOUT_PATH)
    left_profile: Literal["0", "0.0"] | None = Field(None, description="0, or a path_id with it")

    @property
    def height_and_reach(self) -> tuple[float | None, float | None]:
        """H and L in m, from what the row gives; None where it does not give enough."""
        height, reach, ratio = self.fall_height_m, self.runout_length_m, self.h_over_l
        if height is None:
            height = self._drop()
        if height is None and reach is not None and ratio is not None:
            height = ratio * reach
        if reach is None and height is not None and ratio is not None:
            reach = height / ratio
        return height, reach

    @model_validator(mode="after")
    def _height_and_reach_given(self, info: ValidationInfo) -> Self:
        needed = (info.context or {}).get("need_runout", True)
        drop = self._drop()
        if self.runout_elevation_m is not None and drop is None:
            raise wrong("release_elevation_m", "the elevation of the release, or a path_id")
        if drop is not None and drop <= 0.0:
            raise wrong("runout_elevation_m", "an elevation below release_elevation_m")
        given = (self.fall_height_m, self.runout_length_m, self.runout_elevation_m)
        if given == (None, None, None) and (self.h_over_l is not None or not needed):
            if self.runout_sigma_m is not None:
                raise wrong("runout_sigma_m", "empty, or fall_height_m or runout_length_m with it")
            return self
        height, reach = self.height_and_reach
        if height is None:
            accepted = (
                "H in metres, or release_elevation_m and runout_elevation_m, or h_over_l alone"
            )
            raise wrong("fall_height_m", accepted)
        if reach is None and not needed:
            return self
        if reach is None:
            raise wrong("runout_length_m", "L in metres, or h_over_l beside H")
        if drop is not None and abs(drop - height) > ROUNDING * height:
            raise wrong("fall_height_m", f"about {drop:g}, the release less the stop")
        if self.h_over_l is not None and abs(self.h_over_l * reach - height) > ROUNDING * height:
            raise wrong("h_over_l", f"about {height / reach:.4g}, H over L of the row")
        low, high = MEANINGS["h_over_l"].possible
        if self.h_over_l is None and not low <= height / reach <= high:
            raise wrong("runout_length_m", f"a reach by which H over L is from {low:g} to {high:g}")
        return self

    def _drop(self) -> float | None:
        if self.release_elevation_m is None or self.runout_elevation_m is None:
            return None
        return self.release_elevation_m - self.runout_elevation_m


class VelocityRow(Row):
    """One measured speed, at a distance along the profile or at an elevation."""

    event_id: Name = Field(description=ID)
    x_m: Number | None = Field(None, description="the distance along the profile in metres")
    elevation_m: Number | None = Field(None, description=ELEVATION)
    speed_m_s: NotNegative = Field(description="a speed in m/s, not negative")
    speed_sigma_m_s: Positive | None = Field(None, description="m/s, over 0")

    @model_validator(mode="after")
    def _place_given(self) -> Self:
        if self.x_m is None and self.elevation_m is None:
            raise wrong("x_m", "x_m or elevation_m")
        return self
