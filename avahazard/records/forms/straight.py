"""A row of `events.csv` for an event without a profile: only its H and L are known."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, ValidationInfo, model_validator

from avahazard.records.forms.deposit import DepositRow
from avahazard.records.forms.meanings import RATIO
from avahazard.records.forms.row import ELEVATION, Number, Positive, wrong

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
        height, reach = self.fall_height_m, self.runout_length_m
        if height is None:
            height = self._drop()
        if height is None and reach is not None and self.h_over_l is not None:
            height = self.h_over_l * reach
        if reach is None and height is not None and self.h_over_l is not None:
            reach = height / self.h_over_l
        return height, reach

    @model_validator(mode="after")
    def _height_and_reach_given(self, info: ValidationInfo) -> Self:
        needed = (info.context or {}).get("need_runout", True)
        drop = self._drop()
        if self.runout_elevation_m is not None and drop is None:
            raise wrong("release_elevation_m", "the elevation of the release, or a path_id")
        if drop is not None and drop <= 0.0:
            raise wrong("runout_elevation_m", "an elevation below release_elevation_m")
        if self._ratio_alone(needed):
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
        low, high = RATIO.possible
        if self.h_over_l is None and not low <= height / reach <= high:
            raise wrong("runout_length_m", f"a reach by which H over L is from {low:g} to {high:g}")
        return self

    def _ratio_alone(self, needed: bool) -> bool:
        given = (self.fall_height_m, self.runout_length_m, self.runout_elevation_m)
        return given == (None, None, None) and (self.h_over_l is not None or not needed)

    def _drop(self) -> float | None:
        if self.release_elevation_m is None or self.runout_elevation_m is None:
            return None
        return self.release_elevation_m - self.runout_elevation_m
