"""Every sentence of the report has a translation in every language, with the same places."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog

from avahazard.report.language import LANGUAGES, read_catalogue
from docs._tools.catalogues import messages, translated

PACKAGE = Path(__file__).parents[2] / "avahazard"
PLACES = re.compile(r"\{(\w*(?::[^}]*)?)\}")
CODES = LANGUAGES[1:]


@pytest.fixture(scope="module")
def said() -> Catalog:
    """Give all that the program may say in a report."""
    return messages()


def texts(entry: str | tuple[str, ...] | list[str]) -> list[str]:
    return [entry] if isinstance(entry, str) else list(entry)


def places(text: str) -> set[str]:
    """Names and forms of the places; what stands between the items of a list may differ.

    A model in a command, which reports have not, counts as its name.
    """
    found = (place.removesuffix(":command") for place in PLACES.findall(text))
    return {place.replace(" ; ", "; ") for place in found}


@pytest.mark.parametrize("code", CODES)
def test_nothing_is_without_a_translation_and_nothing_is_left_over(
    code: str, said: Catalog
) -> None:
    catalogue = read_catalogue(code)
    known = {(e.context, e.id) for e in catalogue if e.id and translated(e.string)}
    wanted = {(e.context, e.id) for e in said if e.id}
    assert wanted - known == set()
    assert {(e.context, e.id) for e in catalogue if e.id} - wanted == set()


@pytest.mark.parametrize("code", CODES)
def test_translations_have_the_places_of_their_sentence(code: str) -> None:
    for entry in read_catalogue(code):
        wanted = [places(text) for text in texts(entry.id)]
        for text in texts(entry.string) if entry.id else []:
            assert places(text) == wanted[-1], text


@pytest.mark.parametrize("code", CODES)
def test_long_sentences_are_not_english(code: str) -> None:
    for entry in read_catalogue(code):
        same = [text for text in texts(entry.id) if text in texts(entry.string)] if entry.id else []
        assert [
            text for text in same if len(re.findall(r"[a-z]{3,}", PLACES.sub("", text))) > 2
        ] == []


def test_babel_finds_every_sentence_that_is_marked(said: Catalog) -> None:
    known = {text for entry in said if entry.id for text in texts(entry.id)}
    assert set(marked()) - known == set()


def marked() -> Iterator[str]:
    """Texts in calls of `say` and `plural`, by Python's own parser."""
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name in {"say", "plural"}:
                for argument in node.args[: 2 if name == "plural" else 1]:
                    if isinstance(argument, ast.Constant):
                        yield str(argument.value)
