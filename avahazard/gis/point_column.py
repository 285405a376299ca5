"""Points as a column of a GeoParquet file: their bytes, and what the file says of them."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Collection

import numpy as np

from avahazard.gis.systems import WGS84, moved, read_system

Place = tuple[float, float, str]
"""East (or longitude), north, and the system, such as `EPSG:31287`."""


def point_column(systems: Collection[str]) -> tuple[Callable[[Place], bytes], str]:
    """How a place becomes WKB in the one system of the column, and the metadata `geo`.

    That system is the places' own where they share one, else WGS 84 (GeoParquet 1.1).
    """
    known = {name: read_system(name) for name in systems}
    one = next(iter(known.values())) if len(known) == 1 else None
    target = WGS84 if one is None else one

    def wkb(place: Place) -> bytes:
        east, north, name = place
        source = known[name]
        if source is not None and source != target:
            ((east, north),) = moved(np.array([[east, north]]), source, target)
        return struct.pack("<BIdd", 1, 1, east, north)

    about = {
        "version": "1.1.0",
        "primary_column": "geometry",
        "columns": {
            "geometry": {
                "encoding": "WKB",
                "geometry_types": ["Point"],
                "crs": target.to_json_dict(),
            }
        },
    }
    return wkb, json.dumps(about)
