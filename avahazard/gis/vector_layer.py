"""One layer of lines or polygons out of a GeoPackage, GeoJSON, Shapefile, KML or GPX."""

import re
import warnings
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Literal

import numpy as np
import pyogrio
import shapely
from numpy.typing import NDArray
from pyogrio.errors import DataLayerError, DataSourceError
from pyproj import CRS

from avahazard.arrays import Floats
from avahazard.gis.systems import moved, read_system
from avahazard.records.errors import AvahazardError
from avahazard.records.sheet import cell_text

Kind = Literal["line", "polygon", "point"]
OF_THE_FORMAT = re.compile(
    "id|description|timestamp|begin|end|altitudeMode|tessellate|extrude|visibility|drawOrder|icon|"
    "cmt|desc|src|number|type|ele|time|magvar|geoidheight|sym|fix|sat|[hvp]dop|ageofdgpsdata|"
    "dgpsid|link[12]_(?:href|text|type)"
)
"""Attributes that every KML or GPX file has: no columns of the user."""


@dataclass(frozen=True, slots=True, eq=False)
class VectorLayer:
    """Features in the order of the file: `geometry` `[n]`, None if unreadable, and attributes."""

    file: str
    crs: CRS
    columns: tuple[str, ...]
    geometry: NDArray[np.object_]
    attributes: tuple[dict[str, str], ...]


def read_layer(file: FilePath, kind: Kind, near: tuple[Floats, CRS] | None = None) -> VectorLayer:
    """Read the only layer of a kind, or what of it is `near` points `[n, 2]`.

    Raises `AvahazardError` where the file is missing, cannot be read, or has no such layer or more
    than one.
    """
    if not file.is_file():
        raise AvahazardError(
            f"There is no file {file}.", "Name a .gpkg, .geojson, .shp, .kml or .gpx file."
        )
    try:
        with warnings.catch_warnings():
            # GDAL remarks on how the file was written, such as values of M that are left out.
            warnings.simplefilter("ignore")
            crs, (meta, _, geometry, columns) = _read(file, kind, near)
    except UnicodeDecodeError as error:
        raise AvahazardError(
            f"{file} holds text that is not UTF-8: byte {error.object[error.start]:#x} after "
            f"{error.object[: error.start]!r}.",
            "Save it again from your GIS, in UTF-8.",
        ) from error
    except (DataSourceError, DataLayerError) as error:
        raise AvahazardError(
            f"{file} cannot be read: {error}", "Give a GeoPackage, GeoJSON, Shapefile, KML or GPX."
        ) from error
    own = dict(zip(meta["fields"], columns, strict=True))
    if file.suffix.lower() in (".kml", ".kmz", ".gpx"):
        own = {name: column for name, column in own.items() if not OF_THE_FORMAT.fullmatch(name)}
    attributes: list[dict[str, str]] = [{} for _ in geometry]
    for name, column in own.items():
        for row, value in zip(attributes, column, strict=True):
            if text := _text(value):
                row[name] = text
    geometries = shapely.from_wkb(geometry, on_invalid="ignore")
    return VectorLayer(str(file), crs, tuple(own), geometries, tuple(attributes))


def holds_points(file: FilePath) -> bool:
    """Tell whether all that a file holds is points."""
    try:
        types = {type_ for name, type_ in pyogrio.list_layers(file) if type_}
        if file.suffix.lower() == ".gpx":
            return not any(_count(file, name) for name in ("tracks", "routes"))
        if types == {"Unknown"} and len(pyogrio.list_layers(file)) == 1:
            geometry = shapely.from_wkb(pyogrio.raw.read(file)[2], on_invalid="ignore")
            types = {g.geom_type for g in geometry if g is not None}
    except (DataSourceError, DataLayerError, UnicodeDecodeError):
        return False
    return bool(types) and all("Point" in type_ for type_ in types)


def _count(file: FilePath, layer: str) -> int:
    return int(pyogrio.read_info(file, layer=layer, force_feature_count=True)["features"])


def _read(file: FilePath, kind: Kind, near: tuple[Floats, CRS] | None) -> tuple[CRS, Any]:
    name = _layer_name(file, kind)
    crs = read_system(pyogrio.read_info(file, layer=name)["crs"])
    if crs is None:
        raise AvahazardError(
            f"The {kind}s of {file} have no reference system.",
            f"Put {file.with_suffix('.prj').name} beside it, as your GIS writes it."
            if file.suffix.lower() == ".shp"
            else "Give the layer its system in your GIS and save it again.",
        )
    crs = crs.to_2d()
    box = None
    if near is not None:
        xy = moved(*near, crs)
        box = (*xy.min(axis=0), *xy.max(axis=0))
    return crs, pyogrio.raw.read(file, layer=name, force_2d=True, bbox=box)


def _layer_name(file: FilePath, kind: Kind) -> str:
    """The only layer of this kind; one of mixed or unknown kinds counts too."""
    layers: dict[str, str] = {name: type_ or "" for name, type_ in pyogrio.list_layers(file)}
    mixed = ("Unknown", "GeometryCollection")
    fitting = [name for name, type_ in layers.items() if kind in type_.lower() or type_ in mixed]
    if file.suffix.lower() == ".gpx":  # the format names its layers, with or without features
        lines = ("tracks", "routes") if kind == "line" else ("waypoints",)
        fitting = [name for name in lines if _count(file, name)]
    if len(fitting) == 1:
        return fitting[0]
    shown = ", ".join(f"{name} ({type_ or 'a table'})" for name, type_ in layers.items())
    if fitting:
        raise AvahazardError(
            f"{file} has {len(fitting)} layers of {kind}s: {', '.join(fitting)}.",
            f"Save the one that is meant as a file of its own. All layers: {shown}.",
        )
    raise AvahazardError(
        f"{file} has no layer of {kind}s.",
        f"It holds: {shown}." if shown else "It holds no layer at all.",
    )


def _text(value: object) -> str:
    """An attribute as a cell of a table; empty where there is none."""
    if isinstance(value, bytes) or (not isinstance(value, str) and str(value) in ("nan", "NaT")):
        return ""
    # A column of whole numbers with gaps is read as one of floats.
    return cell_text(value.item() if isinstance(value, np.bool_ | np.floating) else value)


COLUMN = "land_cover"
ELSEWHERE = "open"


def cover_at(file: FilePath, xy: Floats, crs: CRS) -> tuple[str, ...]:
    """Land cover at points `[n, 2]` of `crs`: that of the polygon there, `open` elsewhere.

    Where polygons overlap, the first of the file counts. Raises `AvahazardError` where the file
    cannot be used, or its polygons have no `land_cover`.
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
