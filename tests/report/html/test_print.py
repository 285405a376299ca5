"""A report on paper: the paths come last, a sheet each, in real headless Chromium."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.report.language import language_of
from tests.report.html.chromium import Seen, chromium

WIDE, HIGH, GAP = 703, 1009, 40
"""A4 between the margins, and what parts the columns that stand for pages (px)."""
PAGES = """([wide, high, gap]) => {
  const all = document.createElement("div");
  while (document.body.firstChild) { all.appendChild(document.body.firstChild); }
  document.body.appendChild(all);
  all.style.cssText = `height:${high}px;width:${wide}px;columns:${wide}px auto;column-gap:${gap}px;`
    + "column-fill:auto";
  for (const e of document.querySelectorAll("article:has(figure)")) {
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
      high: place.offsetHeight,
    };
  });
}"""
ORDER = "() => [...document.querySelectorAll('main > section')].map((s) => s.id)"


def test_every_path_has_a_sheet_which_its_heading_and_figure_fill(
    loop_content: ReportContent, tmp_path: Path
) -> None:
    file = tmp_path / "de.html"
    # German words are the longest.
    file.write_text(render(replace(loop_content, language=language_of("de"))), encoding="utf-8")
    with chromium() as browser:
        page = Seen(browser, file, WIDE).page
        order = page.evaluate(ORDER)
        for event in ("beforeprint", "afterprint"):
            page.evaluate(f"() => window.dispatchEvent(new Event('{event}'))")
        assert page.evaluate(ORDER) == order
        page.emulate_media(media="print")
        page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
        assert page.evaluate(ORDER) == [name for name in order if name != "paths"] + ["paths"]
        page.wait_for_timeout(400)
        sheets = page.evaluate(PAGES, [WIDE, HIGH, GAP])
    assert len(sheets) == 3
    for k, sheet in enumerate(sheets):
        on = {sheet[what] for what in ("heading", "figure", "words")}
        assert on == {sheets[0]["heading"] + k}
        assert 0.75 * HIGH < sheet["high"] < HIGH
