"""Tables of zones."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO

from rich.console import Console

from avahazard.cli.hazard_tables import show_zones
from avahazard.results.base import Rows
from avahazard.results.zones import ZonedPath
from tests.cli.zone_entries import entry
from tests.telling import untold


def shown(entries: list[ZonedPath]) -> str:
    console = Console(file=StringIO(), width=80)
    show_zones(console, entries)
    file = console.file
    assert isinstance(file, StringIO)
    assert max(map(len, file.getvalue().splitlines())) <= 80
    return " ".join(file.getvalue().split())


def test_one_path_place_by_place() -> None:
    text = shown([entry()])
    assert "P01 30 850 800–930 1537 1515–1552 1.0% P01 300* 850" in text
    assert text.index("Design runout") < text.index("Zones by the limits")
    assert "P01 red none – 700–200" in text
    assert "P01 blue* 100 900 700–beyond" in text
    assert untold(text, "m/s", "kPa") == []
    assert "x m z m p/year u 30 p 30 u 300* p 300*" in text
    assert untold(text, "extrapolation") == []
    assert "900 1600 0.012 100 120 100 120" in text


def test_a_zone_that_begins_beyond_the_profile() -> None:
    one = entry(beyond=True)
    red, blue = one.zones
    one = replace(one, zones=Rows((red, replace(blue, from_x_m=900.0))))
    assert "P01 blue* beyond – 700–beyond" in shown([one])


def test_many_paths_by_their_largest() -> None:
    text = shown([entry(), entry(beyond=True)])
    assert "P01 blue* 100 beyond 700–beyond" in text
    assert "P01 300* 100 90–110 120 30–270" in text
    assert untold(text, "beyond:") == []
