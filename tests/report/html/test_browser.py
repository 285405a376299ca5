"""The report of the small dataset in real headless Chromium."""

from __future__ import annotations

from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from tests.report.html.chromium import Seen, chromium
from tests.report.html.world import EVENT

PAPER_PX = 186 / 25.4 * 96
"""A4 between the margins."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Give a running Chromium."""
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def phone(browser: Any, report_file: Path) -> Seen:
    """Give the report, open and drawn, on a phone."""
    return Seen(browser, report_file, 390)


@pytest.fixture(scope="module")
def desk(browser: Any, report_file: Path) -> Seen:
    """Give the report, open and drawn, on a desk."""
    return Seen(browser, report_file, 1400)


@pytest.fixture(scope="module", params=[pytest.param("phone", marks=pytest.mark.slow), "desk"])
def seen(request: pytest.FixtureRequest) -> Any:
    """Give it on either."""
    return request.getfixturevalue(request.param)


def test_nothing_is_said_asked_for_or_run(seen: Seen, report_file: Path) -> None:
    assert seen.said == []
    assert seen.asked == [report_file.as_uri()]
    assert seen.page.evaluate("() => window.evil") is None


def test_the_page_does_not_scroll_sideways(seen: Seen) -> None:
    assert seen.overflow() <= 0


def test_every_figure_is_drawn(seen: Seen) -> None:
    assert seen.page.locator("[data-figure]").count() >= 14
    assert seen.blank() == []


def test_hovering_an_event_names_it(desk: Seen) -> None:
    assert unescape(desk.point_at_an_event()) in desk.hovered()


def test_a_hostile_name_is_shown_and_not_run(desk: Seen) -> None:
    desk.page.mouse.move(0, 0)
    found = desk.page.evaluate(
        """() => {
          const place = document.querySelector("[data-figure=predicted-elevation]");
          for (const [k, t] of place.data.entries()) {
            const i = (t.text || []).findIndex((text) => text.startsWith("&lt;/script"));
            if (i >= 0) {
              Plotly.Fx.hover(place, [{ curveNumber: k, pointNumber: i }]);
              return true;
            }
          }
          return false;
        }"""
    )
    assert found
    assert EVENT in desk.hovered()
    assert desk.page.evaluate("() => window.evil") is None


def test_it_prints_with_every_figure_on_the_paper(desk: Seen) -> None:
    page = desk.page
    printed = page.pdf(prefer_css_page_size=True)
    assert printed.startswith(b"%PDF")
    assert len(printed) > 100_000
    page.emulate_media(media="print")
    page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    assert widest(page) <= PAPER_PX
    page.emulate_media(media="screen")
    page.evaluate("() => window.dispatchEvent(new Event('afterprint'))")
    assert widest(page) > 1000


def widest(page: Any) -> float:
    """Width of the widest figure, once it is stable."""
    page.wait_for_timeout(400)
    widths = page.evaluate(
        "() => [...document.querySelectorAll('.main-svg')].map((s) => s.clientWidth)"
    )
    return float(max(widths))
