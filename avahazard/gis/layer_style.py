"""How a layer is drawn, in the words of QGIS (QML) and of the OGC (SLD)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, tostring

from avahazard.gis.map_layer import Kind, MapLayer

# Colours that the colour-blind tell apart (Okabe and Ito).
GREY, ORANGE, SKY, GREEN, BLUE, RED = (
    "#666666", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00",
)  # fmt: skip
BY_QUANTILE = {"q05": SKY, "q50": BLUE, "q95": RED}
SLD = "http://www.opengis.net/sld"
SE = "http://www.opengis.net/se"
OGC = "http://www.opengis.net/ogc"
XLINK = "http://www.w3.org/1999/xlink"


@dataclass(frozen=True, slots=True)
class LayerStyle:
    """Colours by the values of an attribute, or one colour (`attribute` None, key "").

    `size` in mm of a mark or a line; `opacity` from 0 to 1.
    """

    kind: Kind
    colors: Mapping[str, str]
    attribute: str | None = None
    size: float = 1.0
    opacity: float = 1.0


def layer_style(layer: MapLayer) -> LayerStyle:
    """The style of a layer: zones in their own colours, runouts by their quantile."""
    zones = (
        {f.attributes["zone"]: f.attributes["color"] for f in layer.features}
        if (layer.topic in ("zones", "zone_areas"))
        else {}
    )
    styles = {
        "paths": LayerStyle("LineString", {"": GREY}, size=0.4),
        "releases": LayerStyle("Point", {"": GREEN}, size=3.0),
        "events": LayerStyle("Point", {"": ORANGE}, size=1.6),
        "volume_runouts": LayerStyle("Point", BY_QUANTILE, "quantile", size=1.6, opacity=0.5),
        "design_runouts": LayerStyle("Point", BY_QUANTILE, "quantile", size=3.2),
        "zones": LayerStyle("LineString", zones, "zone", size=1.2),
        "zone_areas": LayerStyle("Polygon", zones, "zone", opacity=0.4),
    }
    return styles[layer.topic]


def qml(style: LayerStyle) -> str:
    """The style as QGIS stores it."""
    root = Element("qgis", version="3.28.0", styleCategories="Symbology")
    kind = "categorizedSymbol" if style.attribute else "singleSymbol"
    renderer = SubElement(root, "renderer-v2", type=kind, symbollevels="0", forceraster="0")
    if style.attribute:
        renderer.set("attr", style.attribute)
        categories = SubElement(renderer, "categories")
        for i, value in enumerate(style.colors):
            SubElement(
                categories, "category",
                symbol=str(i), value=value, label=value, render="true", type="string",
            )  # fmt: skip
    symbols = SubElement(renderer, "symbols")
    shape, layer, options = _QGIS[style.kind]
    for i, color in enumerate(style.colors.values()):
        symbol = SubElement(symbols, "symbol", type=shape, name=str(i), alpha=f"{style.opacity:g}")
        one = SubElement(symbol, "layer", {"class": layer, "enabled": "1", "locked": "0"})
        one.set("pass", "0")
        values = SubElement(one, "Option", type="Map")
        for name, value in options.items():
            filled = value.format(color=_rgba(color), size=f"{style.size:g}")
            SubElement(values, "Option", name=name, type="QString", value=filled)
    return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n" + tostring(
        root, encoding="unicode"
    )


_QGIS = {
    "Point": (
        "marker",
        "SimpleMarker",
        {"name": "circle", "color": "{color}", "size": "{size}", "size_unit": "MM",
         "outline_color": "255,255,255,255", "outline_width": "0.3", "outline_width_unit": "MM"},
    ),
    "LineString": (
        "line",
        "SimpleLine",
        {"line_color": "{color}", "line_width": "{size}", "line_width_unit": "MM",
         "line_style": "solid", "capstyle": "flat", "joinstyle": "round"},
    ),
    "Polygon": (
        "fill",
        "SimpleFill",
        {"color": "{color}", "style": "solid", "outline_color": "{color}",
         "outline_style": "solid", "outline_width": "0.3", "outline_width_unit": "MM"},
    ),
}  # fmt: skip
"""Of each kind the type of symbol, its layer, and what that is made of."""


def sld(name: str, style: LayerStyle) -> str:
    """The style as a Styled Layer Descriptor (OGC, version 1.1)."""
    root = Element(
        "StyledLayerDescriptor",
        {"version": "1.1.0", "xmlns": SLD, "xmlns:se": SE, "xmlns:ogc": OGC, "xmlns:xlink": XLINK},
    )
    layer = SubElement(root, "NamedLayer")
    SubElement(layer, "se:Name").text = name
    user = SubElement(layer, "UserStyle")
    SubElement(user, "se:Name").text = name
    rules = SubElement(user, "se:FeatureTypeStyle")
    for value, color in style.colors.items():
        rule = SubElement(rules, "se:Rule")
        SubElement(rule, "se:Name").text = value or name
        if style.attribute:
            equal = SubElement(SubElement(rule, "ogc:Filter"), "ogc:PropertyIsEqualTo")
            SubElement(equal, "ogc:PropertyName").text = style.attribute
            SubElement(equal, "ogc:Literal").text = value
        _symbolizer(rule, style, color)
    return tostring(root, encoding="unicode", xml_declaration=True)


def _symbolizer(rule: Element, style: LayerStyle, color: str) -> None:
    pixels = f"{style.size / 0.28:.0f}"  # the OGC's pixel is 0.28 mm
    if style.kind == "LineString":
        stroke = SubElement(SubElement(rule, "se:LineSymbolizer"), "se:Stroke")
        _parameters(stroke, {"stroke": color, "stroke-width": pixels})
    elif style.kind == "Polygon":
        fill = SubElement(SubElement(rule, "se:PolygonSymbolizer"), "se:Fill")
        _parameters(fill, {"fill": color, "fill-opacity": f"{style.opacity:g}"})
    else:
        graphic = SubElement(SubElement(rule, "se:PointSymbolizer"), "se:Graphic")
        mark = SubElement(graphic, "se:Mark")
        SubElement(mark, "se:WellKnownName").text = "circle"
        _parameters(SubElement(mark, "se:Fill"), {"fill": color})
        _parameters(SubElement(mark, "se:Stroke"), {"stroke": "#ffffff"})
        SubElement(graphic, "se:Size").text = pixels


def _parameters(element: Element, values: Mapping[str, str]) -> None:
    for name, value in values.items():
        SubElement(element, "se:SvgParameter", name=name).text = value


def _rgba(color: str) -> str:
    return ",".join(str(int(color[i : i + 2], 16)) for i in (1, 3, 5)) + ",255"
