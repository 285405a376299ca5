"""Reference systems: read, judged for lengths in metres, and what lies in them moved."""

from functools import cache

import numpy as np
import shapely
from pyproj import CRS, Proj, Transformer
from pyproj.aoi import AreaOfInterest
from pyproj.database import query_utm_crs_info
from pyproj.exceptions import CRSError
from rasterio import Affine
from rasterio.transform import from_origin

from avahazard.arrays import Floats
from avahazard.records.collection import TerrainCrop

WGS84 = CRS.from_epsg(4326)
STRETCH = 0.005
"""Share by which lengths on the map may differ from those on the ground: Web Mercator's do by
half in the Alps."""


def read_system(text: str | None) -> CRS | None:
    """Return the reference system that `text` means; None for none, and for one undefined."""
    if not text:
        return None
    try:
        system = CRS.from_user_input(text)
    except CRSError:
        return None
    known = system.is_projected or system.is_geographic
    return None if not known or system.name.lower().startswith("undefined") else system


def system_code(system: CRS) -> str | None:
    """Return a system's name in a register, such as `EPSG:31287`; None where it has none."""
    flat = system.to_2d()
    if (code := flat.to_epsg()) is not None:
        return f"EPSG:{code}"
    found = flat.to_authority()
    return None if found is None else ":".join(found)


def moved(xy: Floats, source: CRS, target: CRS) -> Floats:
    """Points `[n, 2]` (east before north) in another system; inf where they cannot be there."""
    if source == target:
        return xy
    return np.column_stack(_transformer(source, target).transform(xy[:, 0], xy[:, 1]))


def moved_geometry(geometry: shapely.Geometry, source: CRS, target: CRS) -> shapely.Geometry:
    """A geometry in another system."""
    return shapely.transform(geometry, lambda xy: moved(xy, source, target))


def along(xy: Floats) -> Floats:
    """Distance (m) of each point `[n, 2]` from the first, along the line through them."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])


def cells_of(crop: TerrainCrop) -> Affine:
    """From columns and rows of the cells of a path's ground to the map."""
    return from_origin(crop.west_m, crop.north_m, crop.cell_m, crop.cell_m)


def profile_system(candidates: tuple[CRS, ...], place: Floats) -> CRS:
    """The system to measure lengths in near `place` (degrees east, north).

    The first candidate that has a code, counts in metres, and stretches lengths there by less
    than `STRETCH`; else the UTM zone of the place.
    """
    for system in candidates:
        if system_code(system) is not None and _is_true_to_length(system, place):
            return system
    lon, lat = place
    (zone, *_) = query_utm_crs_info("WGS 84", AreaOfInterest(lon, lat, lon, lat))
    return CRS.from_authority(zone.auth_name, zone.code)


def _is_true_to_length(system: CRS, place: Floats) -> bool:
    if not system.is_projected or any(a.unit_conversion_factor != 1.0 for a in system.axis_info):
        return False
    factors = Proj(system).get_factors(*place)
    scales = np.array([factors.meridional_scale, factors.parallel_scale])
    return bool(np.all(np.abs(scales - 1.0) < STRETCH))


@cache
def _transformer(source: CRS, target: CRS) -> Transformer:
    return Transformer.from_crs(source, target, always_xy=True)
