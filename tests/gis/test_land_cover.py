"""Land cover along a path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
from pyproj import CRS

from avahazard.gis.land_cover import cover_at
from avahazard.records.errors import AvahazardError
from tests.gis.surface import CODE, NORTH, WEST, write_lines

XY = np.array([WEST, NORTH]) + np.array([[10.0, 0.0], [60.0, 0.0], [110.0, 0.0], [500.0, 0.0]])


def box(west: float, east: float) -> shapely.Geometry:
    return shapely.box(WEST + west, NORTH - 50.0, WEST + east, NORTH + 50.0)


def test_the_first_polygon_counts_and_all_else_is_open(tmp_path: Path) -> None:
    shapes = [box(50, 100), box(0, 120), None, box(0, 600)]
    cover = {"land_cover": ["forest", "rock", "water", None]}
    file = write_lines(tmp_path / "cover.gpkg", shapes, cover)
    assert cover_at(file, XY, CRS(CODE)) == ("rock", "forest", "rock", "open")


def test_polygons_in_another_system_and_none_near(tmp_path: Path) -> None:
    file = write_lines(
        tmp_path / "cover.geojson",
        [shapely.box(11.3, 47.0, 11.6, 47.6), shapely.box(60.0, 60.0, 61.0, 61.0)],
        {"land_cover": ["forest", "rock"]},
        crs="EPSG:4326",
    )
    found = cover_at(file, np.array([[255_000.0, 382_000.0], [400_000.0, 382_000.0]]), CRS(CODE))
    assert found == ("forest", "open")
    assert cover_at(file, np.array([[400_000.0, 382_000.0]]), CRS(CODE)) == ("open",)


def test_polygons_without_the_attribute(tmp_path: Path) -> None:
    file = write_lines(tmp_path / "cover.gpkg", [box(0, 1)], {"kind": ["forest"]})
    with pytest.raises(AvahazardError, match="no attribute land_cover") as caught:
        cover_at(file, XY, CRS(CODE))
    assert "kind" in caught.value.hint
