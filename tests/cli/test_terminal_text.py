"""What is printed obeys nobody."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from avahazard.cli.output import SafeConsole, safe, safe_json, table

TITLE = "\x1b]0;owned\x07"
BAD = {"escape": "\x1b[2J", "title": TITLE, "c1": "\x9b31m", "bidi": "a\u202eb", "del": "\x7f"}


@pytest.mark.parametrize("text", BAD.values(), ids=BAD.keys())
def test_controls_and_marks_are_shown_not_obeyed(text: str) -> None:
    shown = safe(text)
    assert not any(sign in shown for sign in "\x1b\x07\x9b\u202e\x7f")
    assert len(shown) == len(text)


def test_plain_text_stays_and_long_text_is_cut() -> None:
    assert safe("Aisté, 12 m³\nzwei – „drei“") == "Aisté, 12 m³\nzwei – „drei“"
    assert safe("x" * 130_000, 200) == "x" * 199 + "…"


@pytest.mark.parametrize("text", BAD.values(), ids=BAD.keys())
def test_a_document_means_the_same_without_raw_signs(text: str) -> None:
    document = json.dumps({"name": text}, ensure_ascii=False, indent=2)
    shown = safe_json(document)
    assert json.loads(shown) == {"name": text}
    assert not any(sign in shown for sign in "\x1b\x07\x9b\u202e\x7f")


def test_whatever_a_console_prints_is_safe() -> None:
    out = io.StringIO()
    console = SafeConsole(file=out, force_terminal=True, width=80)
    console.print("\x1b[2Jname\u202e", TITLE)
    console.print(table(TITLE, (TITLE,), [(TITLE + "y" * 130_000,)]))
    shown = out.getvalue()
    assert "\x1b[2J" not in shown
    assert "\x1b]0" not in shown
    assert "\u202e" not in shown
    assert len(shown) < 5_000


def test_hostile_names_through_the_command(
    avahazard: Callable[..., Result], write: Callable[[str, str], Path]
) -> None:
    rows = "".join(f"{TITLE}P,{100 * i},{1000 - 90 * i}\n" for i in range(6))
    write(
        "profiles.csv",
        f"path_id,x_m,y_m,{TITLE}c\n".replace("\n", "\n") + rows.replace("\n", ",\n"),
    )
    folder = write("paths.csv", f"path_id,name,\u202ecolumn\n{TITLE}P,{'n' * 130_000},1\n").parent
    for words in (("import", "--dry-run", str(folder)), ("import", str(folder)), ("paths",)):
        done = avahazard(*words)
        assert done.exit_code == 0, done.stderr
        for shown in (done.stdout, done.stderr):
            assert not any(sign in shown for sign in "\x1b\x07\u202e")
            assert len(shown) < 20_000
    done = avahazard("path", f"{TITLE}Q")
    assert done.exit_code == 1
    assert "\x1b" not in done.stderr
