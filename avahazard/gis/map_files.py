"""Map files: GeoPackage with styles, GeoJSON, GeoTIFF of annual chances."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, Literal, NamedTuple

import numpy as np
import pyogrio
import rasterio
import shapely
from jinja2 import Environment, PackageLoader
from numpy.typing import NDArray
from pyogrio.errors import DataLayerError, DataSourceError
from pyproj import CRS
from rasterio.enums import Resampling
from rasterio.errors import RasterioError
from rasterio.features import rasterize, shapes
from rasterio.transform import array_bounds, from_origin
from rasterio.warp import reproject
from shapely.geometry import mapping, shape

from avahazard.arrays import Bools, Floats
from avahazard.gis.hazard_map import Feature, MapLayer, MappedPath, PathLine
from avahazard.gis.systems import WGS84, cells_of, moved_geometry
from avahazard.records.collection import TerrainCrop
from avahazard.records.errors import AvahazardError
from avahazard.results.base import plain
from avahazard.results.terrain import PERIOD_COLORS

# Colours that the colour-blind tell apart (Okabe and Ito).
GREY, ORANGE, SKY, GREEN, BLUE, RED = (
    "#666666", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00",
)  # fmt: skip
BY_QUANTILE = {"q05": SKY, "q50": BLUE, "q95": RED}
BY_PERIOD = {f"{period:g} years": color for period, color in PERIOD_COLORS.items()}


@dataclass(frozen=True, slots=True)
class LayerStyle:
    """Colours by the values of an attribute, or one by ""; `size` in mm, `opacity` up to 1."""

    colors: Mapping[str, str]
    attribute: str | None = None
    size: float = 1.0
    opacity: float = 1.0


def layer_style(layer: MapLayer) -> LayerStyle:
    """The style of a layer: zones in their own colours, runouts by their quantile."""
    of_zones = layer.features if layer.topic in ("zones", "zone_areas") else ()
    zones = {f.attributes["zone"]: f.attributes["color"] for f in of_zones}
    styles = {
        "paths": LayerStyle({"": GREY}, size=0.4),
        "releases": LayerStyle({"": GREEN}, size=3.0),
        "events": LayerStyle({"": ORANGE}, size=1.6),
        "volume_runouts": LayerStyle(BY_QUANTILE, "quantile", size=1.6, opacity=0.5),
        "design_runouts": LayerStyle(BY_QUANTILE, "quantile", size=3.2),
        "zones": LayerStyle(zones, "zone", size=1.2),
        "zone_areas": LayerStyle(zones, "zone", opacity=0.4),
        "return_periods": LayerStyle(BY_PERIOD, "period", opacity=0.5),
        "return_periods_band": LayerStyle(BY_QUANTILE, "quantile", opacity=0.1),
    }
    return styles[layer.topic]


def style_text(form: Literal["qml", "sld"], layer: MapLayer) -> str:
    """The style of a layer as QGIS stores it, or as a Styled Layer Descriptor (OGC 1.1)."""
    loader = PackageLoader("avahazard.gis", "styles")
    templates = Environment(loader=loader, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return templates.get_template(f"layer.{form}.j2").render(of=layer, style=layer_style(layer))


DIGITS = 7
"""Of a degree: a centimetre."""


def write_geojson(file: FilePath, layers: Sequence[MapLayer]) -> None:
    """Write `layers` to the new file as one collection; `kind` says of which layer a feature is."""
    features = [_feature(layer.topic, feature) for layer in layers for feature in layer.features]
    collection = {"type": "FeatureCollection", "generator": OWNER, "features": features}
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


OWNER = "avahazard"
GEOMETRY = "geom"
STYLES = "layer_styles"


def write_geopackage(file: FilePath, layers: Sequence[MapLayer], day: np.datetime64) -> None:
    """Write `layers` to the new file, each with its style for QGIS, which is of that `day`."""
    for layer in layers:
        _write_table(
            file,
            layer.name,
            [feature.attributes for feature in layer.features],
            geometry=shapely.to_wkb(np.array([f.geometry for f in layer.features], object)),
            geometry_type=layer.kind,
            crs=layer.code,
            layer_options={"GEOMETRY_NAME": GEOMETRY},
        )
    # The table in which QGIS keeps styles (QgsOgrProvider): schema and catalogue are empty text.
    rows = [
        {
            "f_table_catalog": "",
            "f_table_schema": "",
            "f_table_name": layer.name,
            "f_geometry_column": GEOMETRY,
            "styleName": layer.name,
            "styleQML": style_text("qml", layer),
            "styleSLD": style_text("sld", layer),
            "useAsDefault": True,
            "description": "Written by avahazard",
            "owner": OWNER,
            "ui": None,
            "update_time": day,
        }
        for layer in layers
    ]
    _write_table(file, STYLES, rows, geometry=None, layer_options={"FID": "id"})


def is_own_geopackage(file: FilePath) -> bool:
    """Whether `file` was made by `write_geopackage`."""
    try:
        if STYLES not in {name for name, _ in pyogrio.list_layers(file)}:
            return False
        columns = pyogrio.raw.read(file, layer=STYLES, columns=["owner"])[3]
    except (DataSourceError, DataLayerError):
        return False
    return bool(columns) and set(columns[0]) == {OWNER}


def _write_table(file: FilePath, layer: str, rows: list[dict[str, Any]], **options: Any) -> None:
    names = list(rows[0])
    columns = [_column([row[name] for row in rows]) for name in names]
    try:
        pyogrio.raw.write(
            file,
            driver="GPKG",
            layer=layer,
            fields=names,
            field_data=[values for values, _ in columns],
            field_mask=[missing for _, missing in columns],
            **options,
        )
    except (DataSourceError, DataLayerError) as error:
        raise AvahazardError(
            f"{file.parent} cannot be written to: {error}", "Name a file in another folder."
        ) from error


def _column(values: list[Any]) -> tuple[NDArray[Any], Bools | None]:
    """Values as an array of one kind, and a mask of those that are None."""
    missing = np.array([value is None for value in values])
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {str}:
        return np.array(values, dtype=object), None
    if kinds == {np.datetime64}:
        return np.array(values), None
    dtype: type = bool if kinds == {bool} else int if kinds == {int} else float
    filled = [dtype(0) if value is None else dtype(value) for value in values]
    return np.array(filled, dtype=dtype), missing


MOST_CELLS = 200_000_000


class MapGrid(NamedTuple):
    """Square cells, north up: `transform` from columns, rows to the map; `shape` rows, columns."""

    crs: str
    transform: rasterio.Affine
    shape: tuple[int, int]


def grid_of(crops: Sequence[TerrainCrop]) -> MapGrid:
    """The cells that hold the ground of all paths, as fine as the finest; of one system."""
    systems = sorted({crop.crs for crop in crops})
    if len(systems) > 1:
        raise AvahazardError(
            f"The terrain of these paths is in several systems: {', '.join(systems)}.",
            "Draw a map of those in one system: --path PATH, again for each.",
        )
    cell = min(crop.cell_m for crop in crops)
    bounds = np.array([array_bounds(*c.elevation_m.shape, cells_of(c)) for c in crops])
    (west, south), (east, north) = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    sides = np.array([north - south, east - west])
    n_rows, n_columns = (int(n) for n in np.ceil(sides / cell - 1e-6))
    if n_rows * n_columns > MOST_CELLS:
        raise AvahazardError(
            f"A map of all these paths would have {n_rows} times {n_columns} cells.",
            "Draw several maps: --path PATH, again for each path of one.",
        )
    return MapGrid(systems[0], from_origin(west, north, cell, cell), (n_rows, n_columns))


def on_grid(grid: MapGrid, crop: TerrainCrop, values: Floats) -> NDArray[np.float32]:
    """Values in the cells of a path's ground, laid on the map; NaN elsewhere."""
    found = np.full(grid.shape, np.nan, np.float32)
    reproject(
        values.reshape(crop.elevation_m.shape).astype(np.float32),
        found,
        src_transform=cells_of(crop),
        dst_transform=grid.transform,
        src_crs=crop.crs,
        dst_crs=grid.crs,
        src_nodata=np.nan,
        dst_nodata=np.nan,
        resampling=Resampling.nearest,
    )
    return found


def strip_on_grid(
    grid: MapGrid, one: MappedPath, x: Floats, chance: Floats, width_m: float
) -> NDArray[np.float32]:
    """Chances `[n]` at places x (m) along a path's line, over the width of the flow; else NaN."""
    there, line = CRS.from_user_input(grid.crs), one.line
    pieces = [
        (moved_geometry(line.strip(piece, width_m), line.crs, there), value)
        for (start, end), value in zip(pairwise(x.tolist()), chance[1:], strict=True)
        if (piece := line.between(start, end)) is not None
    ]
    if not pieces:
        return np.full(grid.shape, np.nan, np.float32)
    return np.asarray(
        rasterize(pieces, grid.shape, fill=np.nan, transform=grid.transform, dtype="float32")
    )


def write_raster(file: FilePath, grid: MapGrid, bands: Mapping[str, NDArray[np.float32]]) -> None:
    """Write the new file as a cloud-optimised GeoTIFF, NaN as no data; or refuse."""
    try:
        with rasterio.open(
            file, "w", driver="COG", height=grid.shape[0], width=grid.shape[1], count=len(bands),
            dtype="float32", crs=grid.crs, transform=grid.transform, nodata=np.nan,
            compress="deflate",
        ) as target:  # fmt: skip
            for k, (name, values) in enumerate(bands.items(), 1):
                target.write(values, k)
                target.set_band_description(k, name)
            target.update_tags(software=OWNER)
    except RasterioError as error:
        raise AvahazardError(
            f"{file} cannot be written: {error}", "Name a file in another folder."
        ) from error


def is_own_raster(file: FilePath) -> bool:
    """Whether `file` was made by `write_raster`."""
    try:
        with rasterio.open(file) as source:
            return bool(source.tags().get("software") == OWNER)
    except RasterioError:
        return False


def areas(
    grid: MapGrid, inside: Bools, line: PathLine, attributes: Mapping[str, object]
) -> list[Feature]:
    """The cells `inside` as polygons in the system of a path's line, each with the attributes."""
    there = CRS.from_user_input(grid.crs)
    found = shapes(inside.astype(np.uint8), mask=inside, transform=grid.transform)
    geometries = (moved_geometry(shape(cells), there, line.crs) for cells, _ in found)
    return [Feature(line, geometry, dict(attributes)) for geometry in geometries]
