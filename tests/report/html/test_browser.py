"""The report in real headless Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from html import unescape
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib.image as mpimg
import numpy as np
import pytest

from tests.conftest import missing
from tests.report.html.world import EVENT

ARGUMENTS = [
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
DRAWN = "html[data-drawn=all]"
WIDTHS = (390, 1400)
LEAST_INK = 0.0005


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Give a running Chromium."""
    sync_api = pytest.importorskip("playwright.sync_api")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        missing("no chromium is installed")
    with sync_api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield chromium
        chromium.close()


class Seen:
    """An open page with what it said and asked for."""

    def __init__(self, browser: Any, file: Path, width: int) -> None:
        self.page = browser.new_page(viewport={"width": width, "height": 900})
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(file.as_uri())
        self.page.wait_for_selector(DRAWN, state="attached", timeout=120_000)


@pytest.fixture(scope="module", params=WIDTHS)
def seen(request: pytest.FixtureRequest, browser: Any, report_file: Path) -> Iterator[Seen]:
    """Give the report, open and drawn, on a phone and on a desk."""
    opened = Seen(browser, report_file, request.param)
    yield opened
    opened.page.close()


def test_nothing_is_said_asked_for_or_run(seen: Seen, report_file: Path) -> None:
    assert seen.said == []
    assert seen.asked == [report_file.as_uri()]
    assert seen.page.evaluate("() => window.evil") is None


def test_the_page_does_not_scroll_sideways(seen: Seen) -> None:
    wide, window = seen.page.evaluate("() => [document.documentElement.scrollWidth, innerWidth]")
    assert wide <= window


def test_every_figure_is_drawn(seen: Seen) -> None:
    places = seen.page.locator("[data-figure]")
    assert places.count() >= 14
    blank = []
    for k in range(places.count()):
        place = places.nth(k)
        traces = place.locator(".cartesianlayer .trace").count()
        inked = ink(place)
        if traces == 0 or inked < LEAST_INK:
            blank.append((place.get_attribute("data-figure"), traces, inked))
    assert blank == []


def ink(place: Any) -> float:
    """Share of the plotting area that is darker than ground and grid; no axis, no legend."""
    left, top, wide, high = place.evaluate(
        """(place) => {
          const size = place._fullLayout._size;
          return [size.l, size.t, size.w, size.h].map(Math.round);
        }"""
    )
    picture = mpimg.imread(BytesIO(place.screenshot()), format="png")[..., :3]
    inside = picture[top + 4 : top + high - 4, left + 4 : left + wide - 4]
    return float(np.mean(inside.min(axis=-1) < 0.75))


def test_hovering_an_event_names_it(browser: Any, report_file: Path) -> None:
    page = Seen(browser, report_file, 1400).page
    page.locator("[data-figure=predicted-elevation]").scroll_into_view_if_needed()
    # The event that stands farthest from all others.
    text, x, y = page.evaluate(
        """() => {
          const place = document.querySelector("[data-figure=predicted-elevation]");
          const box = place.getBoundingClientRect(), axes = place._fullLayout;
          const marks = place.data.flatMap((t) => (t.text || []).map((text, i) => [text,
            box.left + axes.xaxis._offset + axes.xaxis.d2p(t.x[i]),
            box.top + axes.yaxis._offset + axes.yaxis.d2p(t.y[i])]));
          const room = (a) => Math.min(...marks.filter((b) => b !== a).map(
            (b) => Math.hypot(a[1] - b[1], a[2] - b[2])));
          return marks.reduce((best, a) => room(a) > room(best) ? a : best);
        }"""
    )
    page.mouse.move(x - 40, y - 40)
    page.mouse.move(x, y, steps=4)
    assert unescape(text) in hovered(page)
    page.close()


def test_a_hostile_name_is_shown_and_not_run(browser: Any, report_file: Path) -> None:
    page = Seen(browser, report_file, 1400).page
    found = page.evaluate(
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
    assert EVENT in hovered(page)
    assert page.evaluate("() => window.evil") is None
    page.close()


def hovered(page: Any) -> str:
    """What stands in the box beside the pointer."""
    page.wait_for_selector(".hoverlayer .hovertext", timeout=10_000)
    return "".join(page.locator(".hoverlayer .hovertext").all_text_contents())


def test_it_prints_with_every_figure_on_the_paper(browser: Any, report_file: Path) -> None:
    page = Seen(browser, report_file, 1400).page
    printed = page.pdf(prefer_css_page_size=True)
    assert printed.startswith(b"%PDF")
    assert printed.count(b"/Type /Page\n") + printed.count(b"/Type /Page ") >= 5
    assert len(printed) > 100_000
    # What is laid out for paper is no wider than A4 between its margins (186 mm), and again as
    # wide as the screen has room when it is over.
    page.emulate_media(media="print")
    page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    page.wait_for_timeout(300)
    widths = page.evaluate(
        "() => [...document.querySelectorAll('.main-svg')].map((s) => s.clientWidth)"
    )
    assert max(widths) <= 186 / 25.4 * 96
    page.emulate_media(media="screen")
    page.evaluate("() => window.dispatchEvent(new Event('afterprint'))")
    page.wait_for_timeout(300)
    widths = page.evaluate(
        "() => [...document.querySelectorAll('.main-svg')].map((s) => s.clientWidth)"
    )
    assert max(widths) > 1000
    page.close()
