"""The report in other languages in real headless Chromium: nothing is cut, nothing overlaps."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.report.language import language_of, speaking
from tests.report.html.chromium import Seen, chromium
from tests.report.html.test_browser_loop import OVERLAPS

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

PAPER, HIGH, GAP = 703, 1009, 40
"""A4 between the margins, and what parts the columns that stand for pages (px)."""
PAGES = """([wide, high, gap]) => {
  const all = document.createElement("div");
  while (document.body.firstChild) { all.appendChild(document.body.firstChild); }
  document.body.appendChild(all);
  all.style.cssText = `height:${high}px;width:${wide}px;columns:${wide}px auto;column-gap:${gap}px;`
    + "column-fill:auto";
  for (const e of document.querySelectorAll("#paths, article:has(figure):not(.shares)")) {
    e.style.breakBefore = "column";
  }
  const left = all.getBoundingClientRect().left;
  const page = (e) => Math.round((e.getBoundingClientRect().left - left) / (wide + gap));
  return [...document.querySelectorAll("article")].filter(
    (sheet) => sheet.querySelector("[data-figure^=path-]")
  ).map((sheet) => {
    const place = sheet.querySelector("[data-figure^=path-]");
    const words = sheet.querySelector("figcaption, ul") || place;
    return {
      heading: page(sheet.querySelector("h3")), figure: page(place), words: page(words),
      high: place.offsetHeight, section: page(document.querySelector("#paths h2")),
    };
  });
}"""
ORDER = "() => [...document.querySelectorAll('main > section')].map((s) => s.id)"


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
    with speaking(language_of(request.param)):
        file.write_text(render(loop_content), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def desk(browser: Any, page_file: Path) -> Iterator[Seen]:
    """Give it on a desk."""
    opened = Seen(browser, page_file, 1400)
    yield opened
    opened.page.close()


def test_nothing_is_cut_and_nothing_overlaps_on_a_phone(browser: Any, page_file: Path) -> None:
    seen = Seen(browser, page_file, 390)
    is_whole(seen)
    seen.page.close()


def test_nothing_is_cut_and_nothing_overlaps_on_a_desk(desk: Seen) -> None:
    is_whole(desk)


def is_whole(seen: Seen) -> None:
    seen.page.mouse.move(5, 5)
    assert seen.said == []
    assert seen.overflow() <= 0
    assert seen.page.evaluate(OVERLAPS) == []
    assert seen.page.evaluate(CUT) == []


def test_what_the_script_says_is_in_the_language(desk: Seen) -> None:
    """It has the decimal sign of the language, and no place is left open."""
    words = desk.page.locator(".shown-error").first.inner_text()
    assert re.search(r"\d,\d\sm", words)
    assert "{" not in words


def test_on_paper_nothing_is_cut_and_every_path_fills_a_sheet_after_the_brief(desk: Seen) -> None:
    page = desk.page
    order = page.evaluate(ORDER)
    for event in ("beforeprint", "afterprint"):
        page.evaluate(f"() => window.dispatchEvent(new Event('{event}'))")
    assert page.evaluate(ORDER) == order
    page.emulate_media(media="print")
    page.set_viewport_size({"width": PAPER, "height": 1000})
    page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    page.wait_for_timeout(400)
    assert desk.overflow() <= 0
    assert page.evaluate(WIDE) == []
    assert page.evaluate(OVERLAPS) == []
    assert page.evaluate(CUT) == []
    rest = [name for name in order if name not in ("brief", "paths")]
    assert page.evaluate(ORDER) == ["brief", "paths", *rest]
    sheets = page.evaluate(PAGES, [PAPER, HIGH, GAP])
    assert len(sheets) == 3
    for k, sheet in enumerate(sheets):
        on = {sheet[what] for what in ("heading", "figure", "words")}
        # The first stands under the words on all paths.
        assert on == {sheet["section"] + k}
        assert (0.75 if k else 0.55) * HIGH < sheet["high"] < HIGH
