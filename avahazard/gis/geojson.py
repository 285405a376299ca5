"""Layers as one GeoJSON (RFC 7946): longitude and latitude on WGS 84."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import shapely
from shapely.geometry import mapping

from avahazard.gis.map_layer import Feature, MapLayer
from avahazard.gis.path_line import moved_geometry
from avahazard.gis.systems import WGS84
from avahazard.records.plain import plain

OWNER = "avahazard"
DIGITS = 7
"""Of a degree: a centimetre."""


def write_geojson(file: FilePath, layers: Sequence[MapLayer]) -> None:
    """Write `layers` to the new file as one collection; `kind` says of which layer a feature is."""
    collection = {
        "type": "FeatureCollection",
        "generator": OWNER,
        "features": [
            _feature(layer.topic, feature) for layer in layers for feature in layer.features
        ],
    }
    text = json.dumps(collection, ensure_ascii=False, allow_nan=False)
    file.write_text(text + "\n", encoding="utf-8")


def is_own_geojson(file: FilePath) -> bool:
    """Whether `file` was made by `write_geojson`."""
    start = f'{{"type": "FeatureCollection", "generator": "{OWNER}"'.encode()
    with file.open("rb") as handle:
        return handle.read(len(start)) == start


def _feature(kind: str, feature: Feature) -> dict[str, Any]:
    geometry = moved_geometry(feature.geometry, feature.line.crs, WGS84)
    rounded = shapely.transform(geometry, lambda xy: np.round(xy, DIGITS))
    # Outer rings run against the clock.
    turned = shapely.orient_polygons(rounded, exterior_cw=False)
    return {
        "type": "Feature",
        "geometry": mapping(turned),
        "properties": {"kind": kind, **plain(feature.attributes)},
    }
