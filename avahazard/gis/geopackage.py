"""Layers as a GeoPackage, with their styles."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pyogrio
import shapely
from numpy.typing import NDArray
from pyogrio.errors import DataLayerError, DataSourceError

from avahazard.gis.layer_style import layer_style, qml, sld
from avahazard.gis.map_layer import MapLayer
from avahazard.records.errors import AvahazardError

OWNER = "avahazard"
GEOMETRY = "geom"
STYLES = "layer_styles"


def write_geopackage(file: FilePath, layers: Sequence[MapLayer], day: np.datetime64) -> None:
    """Write `layers` to the new file, each with the style that QGIS takes when it opens it.

    `day` stands with the styles.
    """
    for layer in layers:
        _write(
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
            "styleQML": qml(layer_style(layer)),
            "styleSLD": sld(layer.name, layer_style(layer)),
            "useAsDefault": True,
            "description": "Written by avahazard",
            "owner": OWNER,
            "ui": None,
            "update_time": day,
        }
        for layer in layers
    ]
    _write(file, STYLES, rows, geometry=None, layer_options={"FID": "id"})


def is_own_geopackage(file: FilePath) -> bool:
    """Whether `file` was made by `write_geopackage`."""
    try:
        if STYLES not in {name for name, _ in pyogrio.list_layers(file)}:
            return False
        columns = pyogrio.raw.read(file, layer=STYLES, columns=["owner"])[3]
    except (DataSourceError, DataLayerError):
        return False
    return bool(columns) and set(columns[0]) == {OWNER}


def _write(file: FilePath, layer: str, rows: Sequence[dict[str, Any]], **options: Any) -> None:
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


def _column(values: list[Any]) -> tuple[NDArray[Any], NDArray[np.bool_] | None]:
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
