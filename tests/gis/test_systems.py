"""Reference systems."""

from __future__ import annotations

import numpy as np
import pytest
from pyproj import CRS, Geod

from avahazard.gis.systems import WGS84, moved, profile_system, read_system, system_code

INNSBRUCK = np.array([11.4, 47.3])


@pytest.mark.parametrize(
    "text",
    [
        "",
        None,
        "nonsense",
        'ENGCRS["x",EDATUM["x"],CS[Cartesian,2],AXIS["x",east],'
        'AXIS["y",north],LENGTHUNIT["metre",1]]',
        'GEOGCS["Undefined geographic SRS",DATUM["unknown",'
        'SPHEROID["unknown",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925]]',
    ],
)
def test_what_is_no_system_is_none(text: str | None) -> None:
    assert read_system(text) is None


def test_codes() -> None:
    assert system_code(CRS("EPSG:31287")) == "EPSG:31287"
    assert system_code(CRS("EPSG:25832+5783")) == "EPSG:25832"
    assert system_code(CRS("+proj=tmerc +lat_0=47 +lon_0=11 +ellps=bessel")) is None


@pytest.mark.parametrize(
    ("candidates", "taken"),
    [
        (("EPSG:31287", "EPSG:4326"), "EPSG:31287"),
        (("EPSG:4326", "EPSG:31287"), "EPSG:31287"),
        (("EPSG:3857", "EPSG:4326"), "EPSG:32632"),
        (("EPSG:2263", "EPSG:4258"), "EPSG:32632"),
        (("+proj=tmerc +lat_0=47 +lon_0=11", "EPSG:25832"), "EPSG:25832"),
    ],
)
def test_lengths_are_measured_where_they_are_true(candidates: tuple[str, ...], taken: str) -> None:
    system = profile_system(tuple(CRS(c) for c in candidates), INNSBRUCK)
    assert system_code(system) == taken
    # The witness is the length on the ellipsoid.
    ends = np.array([INNSBRUCK, INNSBRUCK + np.array([0.02, -0.01])])
    ground = Geod(ellps="WGS84").inv(*ends[0], *ends[1])[2]
    there = moved(ends, WGS84, system)
    assert np.hypot(*(there[1] - there[0])) == pytest.approx(ground, rel=1e-3)


def test_points_that_cannot_be_there_are_infinite() -> None:
    assert not np.isfinite(moved(np.array([[500.0, 95.0]]), WGS84, CRS("EPSG:31287"))).any()
