"""What each column of docs/data_forms.md means, in which unit, and what its cells hold."""

from __future__ import annotations

from typing import Literal, NamedTuple

Content = Literal["name", "text", "number", "date", "flag"]


class Meaning(NamedTuple):
    """A column in words; `unit` is empty where it has none."""

    words: str
    unit: str = ""
    content: Content = "number"


def _name(words: str) -> Meaning:
    return Meaning(words, "", "name")


def _text(words: str) -> Meaning:
    return Meaning(words, "", "text")


ELEVATION = "m a.s.l."

MEANINGS: dict[str, Meaning] = {
    "path_id": _name("the path"),
    "event_id": _name("the event"),
    "name": _text("name of the path"),
    "location": _text("where the path is"),
    "orientation": _text("orientation of the path"),
    "section": _text("channelled or open"),
    "catchment_ha": Meaning("catchment area", "ha"),
    "release_elevation_m": Meaning("elevation of the release", ELEVATION),
    "release_sigma_m": Meaning("error of the release elevation (sd)", "m"),
    "observed_from": Meaning("first year of observation"),
    "observed_to": Meaning("last year of observation"),
    "observed_below_m": Meaning("stops above are not seen", ELEVATION),
    "not_observed": _text("years in which nobody looked"),
    "release_area_m2": Meaning("area of the release", "m2"),
    "width_m": Meaning("width of the flow", "m"),
    "x_m": Meaning("horizontal distance from the top", "m"),
    "y_m": Meaning("elevation of the point", ELEVATION),
    "elevation_sigma_m": Meaning("error of the elevation (sd)", "m"),
    "land_cover": _text("land cover from this point on"),
    "easting_m": Meaning("easting", "m"),
    "northing_m": Meaning("northing", "m"),
    "crs": _text("coordinate system"),
    "lon": Meaning("longitude", "degrees"),
    "lat": Meaning("latitude", "degrees"),
    "date": Meaning("date, or year", "", "date"),
    "runout_elevation_m": Meaning("elevation of the stop", ELEVATION),
    "runout_x_m": Meaning("horizontal distance of the stop", "m"),
    "runout_sigma_m": Meaning("error of the runout (sd)", "m"),
    "left_profile": Meaning("ran past the profile's end", "", "flag"),
    "volume_m3": Meaning("volume of the deposit", "m3"),
    "deposit_length_m": Meaning("length of the deposit", "m"),
    "deposit_width_m": Meaning("width of the deposit", "m"),
    "deposit_thickness_m": Meaning("thickness of the deposit", "m"),
    "volume_rel_sigma": Meaning("error of log volume (sd)"),
    "snow_type": _text("type of snow"),
    "fall_height_m": Meaning("height of fall H", "m"),
    "runout_length_m": Meaning("horizontal reach L", "m"),
    "h_over_l": Meaning("H over L"),
    "elevation_m": Meaning("elevation of the speed", ELEVATION),
    "speed_m_s": Meaning("speed", "m/s"),
    "speed_sigma_m_s": Meaning("error of the speed (sd)", "m/s"),
    "return_period_years": Meaning("return period", "years"),
    "year": Meaning("year"),
    "depth_m": Meaning("three-day snow depth", "m"),
}
