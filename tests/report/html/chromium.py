"""A report opened in real headless Chromium."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib.image as mpimg
import numpy as np

from tests.conftest import missing

ARGUMENTS = [
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
DRAWN = "html[data-drawn=all]"
LEAST_INK = 0.0005


@contextmanager
def chromium() -> Iterator[Any]:
    """Give a running Chromium; without one the test is skipped, or fails where it has to be."""
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415
    except ImportError:
        missing("playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        missing("no chromium is installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield browser
        browser.close()


class Seen:
    """An open and drawn report with what it said and asked for."""

    def __init__(self, browser: Any, file: Path, width: int) -> None:
        self.page = browser.new_page(viewport={"width": width, "height": 900})
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(file.as_uri())
        self.page.wait_for_selector(DRAWN, state="attached", timeout=120_000)

    def overflow(self) -> int:
        """By how many pixels the page is wider than its window."""
        wide, window = self.page.evaluate(
            "() => [document.documentElement.scrollWidth, innerWidth]"
        )
        return int(wide - window)

    def blank(self) -> list[str]:
        """Figures without a trace or without ink."""
        places = self.page.locator("[data-figure]")
        found = []
        for k in range(places.count()):
            place = places.nth(k)
            traces = place.locator(".cartesianlayer .trace").count()
            if traces == 0 or ink(place) < LEAST_INK:
                found.append(str(place.get_attribute("data-figure")))
        return found

    def hovered(self) -> str:
        """What stands in the box beside the pointer."""
        self.page.wait_for_selector(".hoverlayer .hovertext", timeout=10_000)
        return "".join(self.page.locator(".hoverlayer .hovertext").all_text_contents())

    def point_at_an_event(self) -> str:
        """Move the pointer on the event that stands farthest from all others; return its words."""
        self.page.locator("[data-figure=predicted-elevation]").scroll_into_view_if_needed()
        text, x, y = self.page.evaluate(
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
        self.page.mouse.move(x - 40, y - 40)
        self.page.mouse.move(x, y, steps=4)
        return str(text)


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
