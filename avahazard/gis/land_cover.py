"""Land cover along a path, from polygons."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import shapely
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.systems import moved
from avahazard.gis.vector_layer import read_layer
from avahazard.records.errors import AvahazardError

COLUMN = "land_cover"
ELSEWHERE = "open"


def cover_at(file: FilePath, xy: Floats, crs: CRS) -> tuple[str, ...]:
    """Land cover at points `[n, 2]` of `crs`: that of the polygon there, `open` elsewhere.

    Where polygons overlap, the first of the file counts.

    Raises:
        AvahazardError: the file cannot be used, or its polygons have no `land_cover`.
    """
    layer = read_layer(file, "polygon", near=(xy, crs))
    if COLUMN not in layer.columns:
        raise AvahazardError(
            f"The polygons of {file} have no attribute {COLUMN}.",
            f"They have: {', '.join(layer.columns) or 'none'}. Name the one with words such as "
            f"forest {COLUMN}.",
        )
    known = [i for i, row in enumerate(layer.attributes) if COLUMN in row and layer.geometry[i]]
    polygons = shapely.make_valid(layer.geometry[known])
    points = shapely.points(moved(xy, crs, layer.crs))
    cover = [ELSEWHERE] * len(xy)
    point, polygon = shapely.STRtree(polygons).query(points, predicate="intersects")
    # From the last polygon to the first, so that the first has the last word.
    for k in np.argsort(-polygon, kind="stable"):
        cover[point[k]] = layer.attributes[known[polygon[k]]][COLUMN]
    return tuple(cover)
