"""The columns that every event may have: its date, the errors of its record, its volume."""

from __future__ import annotations

import datetime as dt
import re
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from avahazard.records.forms.row import (
    ELEVATION,
    ID,
    Name,
    NotNegative,
    Number,
    Positive,
    Row,
    wrong,
)

LENGTH = "metres, over 0"
YEAR_ONLY = re.compile(r"[0-9]{4}")
FULL_DATE = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")


def _iso_date(text: str) -> str:
    if FULL_DATE.fullmatch(text):
        dt.date.fromisoformat(text)
    elif not YEAR_ONLY.fullmatch(text) or text == "0000":
        raise ValueError(text)
    return text


Date = Annotated[str, AfterValidator(_iso_date)]


class DepositRow(Row):
    """An event without its place: the two forms of an event build on it."""

    event_id: Name = Field(description=ID)
    date: Date | None = Field(None, description="a date as 1950-02-13, or a year as 1950")
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
        if self.volume_m3 is not None:
            return self
        sides = ("deposit_length_m", "deposit_width_m", "deposit_thickness_m")
        missing = [name for name in sides if getattr(self, name) is None]
        alone = missing == list(sides[1:])
        if 0 < len(missing) < 3 and not alone:
            raise wrong(missing[0], "length, width and thickness of the deposit, or volume_m3")
        return self
