"""The switch of the report in real headless Chromium."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from avahazard.report.html.content import ReportContent
from tests.report.html.chromium import Seen, chromium

# A phone sees the report in German (`test_browser_languages.py`).
WIDTHS = (pytest.param(390, marks=pytest.mark.slow), 1400)
PAGE_PX = (297 - 30) / 25.4 * 96
"""A4 between the margins."""
WORDS_PX = 80
"""A heading, and the words below a figure."""
OVERLAPS = """() => {
  const hit = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  const box = (e) => e.getBoundingClientRect();
  const found = [];
  document.querySelectorAll("[data-figure]").forEach((place) => {
    const name = place.dataset.figure;
    const legend = place.querySelector(".legend"), bar = place.querySelector(".modebar");
    if (legend && bar && hit(box(legend), box(bar))) { found.push([name, "toolbar on legend"]); }
    const edge = box(place);
    place.querySelectorAll("text").forEach((text) => {
      const b = box(text);
      const out = b.width > 0 && (b.left < edge.left - 1 || b.right > edge.right + 1);
      if (out) { found.push([name, "cut", text.textContent]); }
    });
    const titles = [".ytitle", ...Array.from({length: 8}, (_, k) => `.y${k + 2}title`)].join(", ");
    for (const kind of [".xtick text", ".ytick text", titles]) {
      const ticks = [...place.querySelectorAll(kind)].map((e) => [box(e), e.textContent]);
      ticks.forEach((a, i) => ticks.slice(i + 1).forEach((b) => {
        if (hit(a[0], b[0])) { found.push([name, a[1], b[1]]); }
      }));
    }
  });
  return found;
}"""

PANELS = """() => Object.fromEntries([...document.querySelectorAll("[data-figure]")].map(
  (place) => [place.dataset.figure, [place.clientHeight,
    ...[...place.querySelectorAll(".subplot")].map(
      (e) => e.querySelector(".bg, .gridlayer").getBoundingClientRect().height)]]))"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Give a running Chromium."""
    with chromium() as started:
        yield started


@pytest.fixture(scope="module", params=WIDTHS)
def seen(request: pytest.FixtureRequest, browser: Any, loop_file: Path) -> Iterator[Seen]:
    """Give the report of the child, on a phone and on a desk."""
    opened = Seen(browser, loop_file, request.param)
    yield opened
    opened.page.close()


def shown_error(seen: Seen) -> float:
    """The first figure of the words beside the switch: the error on all records."""
    words = seen.page.locator("#check .shown-error").inner_text()
    return float(re.findall(r"(\d+\.\d)\sm", words)[0])


def drawn_middles(seen: Seen) -> list[float]:
    """x of the first trace of measured against predicted."""
    return list(
        seen.page.evaluate(
            "() => Array.from(document.querySelector('[data-figure^=predicted]').data[0].x)"
        )
    )


def test_nothing_is_said_nor_cut(seen: Seen) -> None:
    assert seen.said == []
    assert seen.overflow() <= 0
    assert seen.blank() == []


def test_nothing_overlaps(seen: Seen) -> None:
    seen.page.mouse.move(5, 5)
    assert seen.page.evaluate(OVERLAPS) == []


def test_the_switch_redraws_and_shows_the_error_of_compare(
    seen: Seen, loop_content: ReportContent
) -> None:
    drawn = {}
    for name in ("base", "child"):
        seen.page.locator(f"#check input[value={name}]").click()
        drawn[name] = drawn_middles(seen)
        error = loop_content.loop.comparisons[name].scores.runout.crps_m
        assert shown_error(seen) == pytest.approx(error, rel=0.01)
        held_out = loop_content.loop.comparisons[name].held_out.runout.crps_m
        words = seen.page.locator("#check .shown-error").inner_text().replace("\u00a0", " ")
        assert f"held-out {held_out:.1f} m" in words
    assert drawn["base"] != drawn["child"]


def test_on_paper_two_figures_go_on_a_page_and_panels_can_be_read(seen: Seen) -> None:
    heights = "() => [...document.querySelectorAll('[data-figure]')].map((p) => p.clientHeight)"
    before = seen.page.evaluate(heights)
    seen.page.emulate_media(media="print")
    seen.page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    assert max(seen.page.evaluate(heights)) <= PAGE_PX - WORDS_PX
    panels = seen.page.evaluate(PANELS)
    assert len(panels["path-1"]) >= 3
    for name, (high, *each) in panels.items():
        if len(each) == 1:
            assert high <= PAGE_PX / 2 - WORDS_PX, name
        else:
            # The first path shares its sheet with the words on all paths.
            assert min(each) >= (45 if name == "path-1" else 60), name
            assert each[0] >= (150 if name == "path-1" else 200), name
    assert seen.page.locator("details:not([open])").count() == 0
    assert not seen.page.locator("[data-path]").first.is_visible()
    seen.page.emulate_media(media="screen")
    seen.page.evaluate("() => window.dispatchEvent(new Event('afterprint'))")
    assert seen.page.evaluate(heights) == before
