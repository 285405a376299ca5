"""A layer of a map to be written: features of one kind in one reference system."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import shapely

from avahazard.gis.path_line import PathLine

Kind = Literal["Point", "LineString", "Polygon"]


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """A geometry in the system of `line`, with its attributes: text, numbers, flags or None."""

    line: PathLine
    geometry: shapely.Geometry
    attributes: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class MapLayer:
    """Features that all have the same attributes; `topic` is its name without a system."""

    name: str
    topic: str
    kind: Kind
    features: tuple[Feature, ...]

    @property
    def code(self) -> str:
        """The system of its features."""
        return self.features[0].line.code


def layers_by_system(topic: str, kind: Kind, features: Sequence[Feature]) -> list[MapLayer]:
    """One layer of the features, none where there are none.

    One for each system where they are in several: `paths_31287`, `paths_32632`.
    """
    by_code: dict[str, list[Feature]] = {}
    for feature in features:
        by_code.setdefault(feature.line.code, []).append(feature)
    layers = [MapLayer(topic, topic, kind, tuple(some)) for some in by_code.values()]
    if len(layers) == 1:
        return layers
    return [replace(layer, name=f"{topic}_{_short(layer.code)}") for layer in layers]


def _short(code: str) -> str:
    return re.sub(r"\W+", "_", code.lower().removeprefix("epsg:"))
