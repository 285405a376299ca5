"""Values and tables for people."""

from __future__ import annotations

import errno
import os
from io import StringIO

import pytest
from rich.console import Console

from avahazard.cli.output import show_error, table
from avahazard.report.language import TERMINAL, speaking
from avahazard.report.tables import cell


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (True, "yes"),
        (3, "3"),
        ("x", "x"),
        (0.0, "0"),
        (0.51234567, "0.5123"),
        (1234.56, "1235"),
        (123456.7, "123457"),
        (2.0e-7, "2e-07"),
        (1.2e7, "1.2e+07"),
    ],
)
def test_numbers_for_people(value: object, text: str) -> None:
    with speaking(TERMINAL):
        assert cell(value) == text


def test_a_long_word_is_folded_not_cut() -> None:
    stream = StringIO()
    console = Console(file=stream, width=80)
    console.print(table("T", ("path", ">value"), [("x" * 150, 1.5)]))
    assert stream.getvalue().count("x") == 150
    assert max(map(len, stream.getvalue().splitlines())) <= 80


@pytest.mark.parametrize(
    ("number_", "hint"),
    [(errno.ENOSPC, "make room"), (errno.EROFS, "permissions"), (errno.ENOENT, "are there")],
)
def test_what_a_disk_refuses_has_a_remedy(
    number_: int, hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    show_error(OSError(number_, os.strerror(number_), "bounds.csv"))
    told = capsys.readouterr().err
    assert "bounds.csv" in told
    assert hint in told


def test_numbers_are_never_folded() -> None:
    """Half of 3.95e-06 at the end of a line reads as another number."""
    stream = StringIO()
    words = "a long name that is folded as it does not fit beside so many numbers, of course"
    heads = ("", *(f">heading of many words {k}" for k in range(6)), "unit")
    row = (words, *[3.95e-6] * 6, "log friction per (60 days)²")
    Console(file=stream, width=80).print(table("T", heads, [row]))
    assert stream.getvalue().count("3.95e-06") == 6
    assert max(map(len, stream.getvalue().splitlines())) <= 80


@pytest.mark.parametrize("name", ["base-turbulent-drag-forest-drag", "base+change:all+path-effect"])
def test_a_long_name_is_broken_after_its_marks(name: str) -> None:
    stream = StringIO()
    Console(file=stream, width=30).print(table("T", ("model", ">CRPS, m"), [(name, "175.7")]))
    below = stream.getvalue().rpartition("─")[2]
    lines = [line.split()[0] for line in below.splitlines() if line.strip()]
    assert "".join(lines) == name
    assert all(line[-1] in "-+:" for line in lines[:-1])
    assert len(lines) > 1


def test_names_of_paths_are_whole_beside_many_numbers() -> None:
    stream = StringIO()
    heads = ("path", *(f">x{k}, m" for k in range(8)), "years")
    rows = [(name, *["2450-2"] * 8, "1905–2003") for name in ("Gurrazgraben", "Entremène-Süd")]
    Console(file=stream, width=80).print(table("T", heads, rows))
    assert "Gurrazgraben" in stream.getvalue()
    assert "Entremène-" in stream.getvalue()
    assert max(map(len, stream.getvalue().splitlines())) <= 80
