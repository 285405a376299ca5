"""What people read has the field's words: no term of our own in help, messages, pages, comments."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.main import get_command

from avahazard.cli.main import app
from avahazard.notes import SENTENCES, TERMINAL
from avahazard.report.language import LANGUAGES, read_catalogue
from tests.cli.test_help import commands

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    *sorted(ROOT.glob("*.md")),
    ROOT / "data/README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
FOLDERS = ("avahazard", "benchmarks", "docs/_tools", "migrations", "qgis", "tests")
CODE = re.compile(
    r"^```.*?^```$|`[^`\n]*`|\]\([^)]*\)|<[^>]+>|[\w/]+\.(py|md|jsonl)\b", re.MULTILINE | re.DOTALL
)
"""Blocks and words of code, addresses, tags, names of files."""

BLANK = {tokenize.NL, tokenize.ENCODING}
EDGES = {tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.COMMENT, tokenize.ENDMARKER}

NOT_BUT = {
    r"\bworlds?\b|made-up": "synthetic dataset",
    r"\bheld out\b|kept back|\bunseen\b|ha[sd] not seen|not seen by": "held-out",
    r"(is|are|was|were) not seen": "undetected",
    r"on its own records|on all records of the calibration": "in-sample",
    r"\b(left|leaves?|leaving) (the|its|their|any) profile": "beyond the profile",
    r"\btold\b|\btells\b": "reported, indicates",
    r"limit of sight": "detection limit",
    r"alone would leave|errors? of the records? alone": "measurement-error floor",
    r"% sure|what it may be": "90 % credible interval",
    r"bears? wrong": "robust to outliers (Student t)",
    r"\bcom(e|es|ing) out\b|\bcame out\b": "result",
    r"\blikelier\b": "more likely, log evidence in nats",
    r"knows the errors": "accounts for measurement error",
    r"prior speaks": "prior-dominated",
    r"times in 5\b": "80 % power",
    r"10\^\d+ times": "log evidence in nats",
    r"less far down": "model overshoots",
    r"another question": "runout for the T-year volume",
    r"compared models it has": "lowest held-out CRPS of n models",
    r"which line for which": "design runout by path",
    r"\bmend(ed|ing|s)?\b": "correct",
    r"meant so": "suppress range warnings",
    r"varies from avalanche to avalanche": "natural variability",
    r"\bnought\b": "zero",
    r"\bclimb(s|ed|ing)?\b": "maximise",
    r"\bsharpen(ed|s)?\b|\bsettled\b": "refined, converged",
    r"\brungs?\b": "ladder entry",
    r"\bat hand\b": "precomputed",
    r"(classes|avalanches|events) to come": "future events",
    r"fixed before the run|as it came out|of the version of \d": "no history in the docs",
}
"""Left column of the style table, as patterns, and what stands in its place."""


def helps() -> Iterator[tuple[str, str]]:
    """Every command's help, and that of its parameters."""
    for name, command in commands(get_command(app)):
        yield name, re.sub(r"--\w+", "", command.help or "")
        for parameter in command.params:
            yield f"{name} {parameter.name}", getattr(parameter, "help", None) or ""


def catalogue_texts() -> Iterator[tuple[str, str]]:
    """Every sentence of the report and of the notes."""
    for message in read_catalogue("de"):
        for text in (message.id,) if isinstance(message.id, str) else message.id:
            yield text, text
    for key, sentence in {**SENTENCES, **TERMINAL}.items():
        for text in (sentence,) if isinstance(sentence, str) else sentence:
            yield key, text


def refusals() -> Iterator[tuple[str, str]]:
    """What the program refuses, and the hints with it."""
    for file in sorted((ROOT / "avahazard").rglob("*.py")):
        for call in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "AvahazardError":
                for part in ast.walk(call):
                    if isinstance(part, ast.Constant) and isinstance(part.value, str):
                        yield f"{file.name}, line {part.lineno}", part.value


def found_in(texts: Iterator[tuple[str, str]]) -> list[str]:
    """What of the left column stands in the texts, where, and what is meant."""
    return [
        f"{where}: “{hit.group()}”, say: {but}"
        for where, text in texts
        for pattern, but in NOT_BUT.items()
        if (hit := re.search(pattern, " ".join(text.split()), re.IGNORECASE))
    ]


def test_help_has_none_of_our_own_terms() -> None:
    assert found_in(helps()) == []


def test_refusals_have_none_of_our_own_terms() -> None:
    assert len(list(refusals())) > 200
    assert found_in(refusals()) == []


def test_the_catalogue_has_none_of_our_own_terms() -> None:
    assert found_in(catalogue_texts()) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_page_has_any_of_our_own_terms(page: Path) -> None:
    text = CODE.sub(" ", page.read_text(encoding="utf-8"))
    assert found_in((f"{page.name}: {line[:60]}", line) for line in text.split("\n\n")) == []


@pytest.mark.parametrize("code", [code for code in LANGUAGES if code != "en"])
def test_translations_have_none_of_our_own_terms(code: str) -> None:
    german = r"Kreislauf|Entstehung|zurückbehalten|zu 90 % sicher"
    words = {"de": german, "fr": r"mis de côté", "it": r"messi da parte"}[code]
    texts = (str(message.string) for message in read_catalogue(code))
    assert [text for text in texts if re.search(words, text)] == []


def prose(file: Path) -> Iterator[tuple[str, str]]:
    """Docstrings of a file and of what it defines, and its comments, without code in them."""
    text = file.read_text(encoding="utf-8")
    tokens = [
        t for t in tokenize.generate_tokens(io.StringIO(text).readline) if t.type not in BLANK
    ]
    for before, token, after in zip([None, *tokens], tokens, [*tokens[1:], None], strict=False):
        alone = (before is None or before.type in EDGES) and (after is None or after.type in EDGES)
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and alone):
            yield f"{file.relative_to(ROOT)}, line {token.start[0]}", CODE.sub(" ", token.string)


@pytest.mark.parametrize("folder", FOLDERS)
def test_docstrings_and_comments_have_none_of_our_own_terms(folder: str) -> None:
    files = [file for file in sorted((ROOT / folder).rglob("*.py")) if file != Path(__file__)]
    assert files
    assert found_in(hit for file in files for hit in prose(file)) == []
