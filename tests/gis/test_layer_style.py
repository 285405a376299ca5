"""Styles of the layers."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from avahazard.gis.hazard_map import hazard_layers
from avahazard.gis.layer_style import layer_style, qml, sld
from avahazard.gis.map_layer import MapLayer
from tests.gis.results import bounds, zones
from tests.gis.test_hazard_map import drawn

LAYERS = {m.name: m for m in hazard_layers([drawn()], [bounds()], [zones()])}
SPACES = {"se": "http://www.opengis.net/se", "ogc": "http://www.opengis.net/ogc"}


@pytest.mark.parametrize("layer", LAYERS.values(), ids=LAYERS)
def test_every_category_has_a_symbol_and_every_feature_a_category(layer: MapLayer) -> None:
    style = layer_style(layer)
    root = ElementTree.fromstring(qml(style))
    renderer = root.find("renderer-v2")
    assert renderer is not None
    symbols = [s.get("name") for s in renderer.findall("symbols/symbol")]
    assert [s.get("type") for s in renderer.findall("symbols/symbol")] == [
        {"Point": "marker", "LineString": "line", "Polygon": "fill"}[layer.kind]
    ] * len(symbols)
    rules = ElementTree.fromstring(sld(layer.name, style)).findall(".//se:Rule", SPACES)
    if style.attribute is None:
        assert (renderer.get("type"), symbols, len(rules)) == ("singleSymbol", ["0"], 1)
        return
    categories = renderer.findall("categories/category")
    assert [c.get("symbol") for c in categories] == symbols
    values = {c.get("value") for c in categories}
    assert {f.attributes[style.attribute] for f in layer.features} <= values
    literals = {r.findtext(".//ogc:Literal", namespaces=SPACES) for r in rules}
    assert literals == values


def test_zones_have_their_own_colours() -> None:
    red = ElementTree.fromstring(qml(layer_style(LAYERS["zones"]))).find(
        ".//Option[@name='line_color']"
    )
    assert red is not None
    assert red.get("value") == "200,16,46,255"
    assert "#c8102e" in sld("zones", layer_style(LAYERS["zones"]))
