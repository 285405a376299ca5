"""The report in other languages in real headless Chromium: nothing is cut, nothing overlaps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.report.language import language_of
from tests.report.html.chromium import Seen, chromium
from tests.report.html.test_browser_loop import MOVE, OVERLAPS

SLOW = pytest.mark.slow
# German words are the longest.
CODES = ("de", pytest.param("fr", marks=SLOW), pytest.param("it", marks=SLOW))
CUT = """() => {
  const found = [];
  document.querySelectorAll("[data-figure]").forEach((place) => {
    const edge = place.getBoundingClientRect();
    place.querySelectorAll("text").forEach((text) => {
      const b = text.getBoundingClientRect();
      if (b.width > 0 && (b.top < edge.top - 1 || b.bottom > edge.bottom + 1)) {
        found.push([place.dataset.figure, text.textContent]);
      }
    });
  });
  const words = "p, h1, h2, h3, h4, li, label, summary, td, th, caption";
  document.querySelectorAll(words).forEach((e) => {
    const clipped = getComputedStyle(e).overflow !== "visible" || e.closest(".table");
    if (!clipped && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0) {
      found.push([e.tagName, e.textContent.trim().slice(0, 60)]);
    }
  });
  return found;
}"""


WIDE = """() => [...document.querySelectorAll("table")].filter((t) => t.scrollWidth
  > document.querySelector("main").clientWidth + 1).map((t) => [t.id, t.scrollWidth])"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Give a running Chromium."""
    with chromium() as started:
        yield started


@pytest.fixture(scope="module", params=CODES)
def page_file(
    request: pytest.FixtureRequest, loop_content: ReportContent, tmp_path_factory: Any
) -> Path:
    """Give the report of the loop in a language."""
    file: Path = tmp_path_factory.mktemp("languages") / f"{request.param}.html"
    content = replace(loop_content, language=language_of(request.param))
    file.write_text(render(content), encoding="utf-8")
    return file


@pytest.mark.parametrize("width", [390, 1400])
def test_nothing_is_cut_and_nothing_overlaps(browser: Any, page_file: Path, width: int) -> None:
    seen = Seen(browser, page_file, width)
    seen.page.mouse.move(5, 5)
    assert seen.said == []
    assert seen.overflow() <= 0
    assert seen.page.evaluate(OVERLAPS) == []
    assert seen.page.evaluate(CUT) == []
    if width == 1400:
        sliders_speak(seen)
        on_paper(seen)
    seen.page.close()


def sliders_speak(seen: Seen) -> None:
    """What the script says has the decimal sign of the language, and no place is left open."""
    slider = seen.page.locator("[data-block=mu]").first
    slider.evaluate(MOVE, 0.345)
    words = seen.page.locator(".stop").first.inner_text()
    assert "0,345" in words
    assert "{" not in words + seen.page.locator(".shown-error").first.inner_text()
    assert "0,345" in seen.page.locator("[data-block=mu] + output").first.inner_text()


def on_paper(seen: Seen) -> None:
    """On paper too nothing is cut."""
    seen.page.emulate_media(media="print")
    seen.page.set_viewport_size({"width": 703, "height": 1000})
    seen.page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    seen.page.wait_for_timeout(300)
    assert seen.overflow() <= 0
    assert seen.page.evaluate(WIDE) == []
    assert seen.page.evaluate(OVERLAPS) == []
    assert seen.page.evaluate(CUT) == []
