"""The report in German, French and Italian: nothing English is left, all figures are the same."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from typing import Any

import pytest

from avahazard.notes import Note
from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.report.language import language_of, speaking
from tests.report.html.world import EVENT, NAMES

SLOW = pytest.mark.slow
# That nothing lacks a translation is tested of all catalogues, in tests/report.
CODES = ("de", pytest.param("fr", marks=SLOW), pytest.param("it", marks=SLOW))
SPOKEN = {"title", "label", "aria-label", "name", "text", "hovertemplate", "data-label"}
WORDS = re.compile(
    r"\b(the|of|and|with|that|which|are|were|from|this|what|where|their|than|records|recorded|"
    r"years|runout|beyond)\b"
)
COMMAND = re.compile(r"avahazard [a-z]+ [\w-]+( [\w:-]+)*|--[a-z]+ \w+|\w+_\w+|\w+\.csv|`\w+`")
OWN = (*NAMES.values(), EVENT, "Words on <physics>.", "covariate:<b>wind</b>", "<b>wind</b>")


class Texts(HTMLParser):
    """What people see or hear of a page: text nodes, labels, and the words of its figures."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.cells: list[str] = []
        self.figures: list[dict[str, Any]] = []
        self._inside: list[tuple[str, bool]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.texts += [value for key, value in attrs if key in SPOKEN and value]
        if tag not in {"input", "meta", "link", "img"}:
            self._inside.append((tag, ("type", "application/json") in attrs))

    def handle_endtag(self, tag: str) -> None:
        while self._inside and self._inside.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        tag, is_json = self._inside[-1] if self._inside else ("", False)
        if tag == "script" and is_json:
            value = json.loads(data)
            if "data" in value:
                self.figures.append(value)
                self.texts += list(spoken(value))
        elif tag not in {"script", "style"} and data.strip():
            self.texts.append(data.strip())
            if tag in {"td", "th"}:
                self.cells.append(data.strip().replace("\u2011", "-"))


def spoken(value: Any, key: str = "") -> Iterator[str]:
    """The words in a figure."""
    if isinstance(value, dict):
        for name, item in value.items():
            if name not in {"states", "font", "meta", "legendgroup"}:
                yield from spoken(item, name)
    elif isinstance(value, list):
        for item in value:
            yield from spoken(item, key)
    elif isinstance(value, str) and key in SPOKEN:
        yield value


def english(text: str) -> bool:
    """Whether a text has English words that are no name, command or key."""
    plain = text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
    for own in OWN:
        plain = plain.replace(own, "")
    return bool(WORDS.search(COMMAND.sub("", plain)))


@pytest.fixture(scope="module")
def pages(content: ReportContent, loop_content: ReportContent) -> Any:
    """Give the texts of both reports in a language."""

    @cache
    def read(code: str) -> list[Texts]:
        with speaking(language_of(code)):
            return [Texts(render(c)) for c in (content, loop_content)]

    return read


def test_the_search_knows_english(pages: Any) -> None:
    assert sum(english(text) for page in pages("en") for text in page.texts) > 200


@pytest.mark.parametrize("code", CODES)
def test_no_english_is_left(code: str, pages: Any) -> None:
    for page in pages(code):
        assert [text for text in page.texts if english(text)] == []


@pytest.mark.parametrize("code", CODES)
def test_the_cells_show_the_same_digits(code: str, pages: Any) -> None:
    def digits(text: str) -> list[str]:
        return sorted(re.sub(r"\D", "", text))

    for own, other in zip(pages("en"), pages(code), strict=True):
        assert len(own.cells) == len(other.cells)
        pairs = zip(own.cells, other.cells, strict=True)
        told = [(a, b) for a, b in pairs if digits(month(a)) != digits(month(b))]
        assert told == []


def month(text: str) -> str:
    """Dates without their month, which some languages write as a word."""
    text = re.sub(r"(\d{4})-\d\d-0?(\d+)", r"\1 \2", text)
    return re.sub(r"\b0?(\d{1,2})\.\d\d\.(\d{4})", r"\1 \2", text)


@pytest.mark.parametrize("code", CODES)
def test_the_figures_draw_the_same(code: str, pages: Any) -> None:
    drawn = ("x", "y", "error_x", "error_y", "marker", "line")
    for own, other in zip(pages("en"), pages(code), strict=True):
        for selected, theirs in zip(own.figures, other.figures, strict=True):
            for a, b in zip(selected["data"], theirs["data"], strict=True):
                numbers = [
                    [v for v in t.get(key) or () if not isinstance(v, str)]
                    if key in "xy"
                    else t.get(key)
                    for t in (a, b)
                    for key in drawn
                ]
                assert numbers[: len(drawn)] == numbers[len(drawn) :]


@pytest.mark.parametrize("code", CODES)
def test_cells_have_the_decimal_sign_of_the_language(
    code: str, pages: Any, content: ReportContent
) -> None:
    versions = set(content.versions.values())
    seen = 0
    for own, other in zip(pages("en"), pages(code), strict=True):
        for a, b in zip(own.cells, other.cells, strict=True):
            if re.fullmatch(r"[−+]?\d+\.\d+( ?%| m| m/s)?", a) and a not in versions:
                assert b == a.replace(".", ",")
                seen += 1
    assert seen > 50


def test_an_unknown_note_does_not_break_a_page(content: ReportContent) -> None:
    row = replace(content.rows[0], notes=(Note.ready("Nobody knows {this} note."),))
    with speaking(language_of("de")):
        page = render(replace(content, rows=[row]))
    assert "Nobody knows {this} note." in page
