"""Values and tables for people."""

from __future__ import annotations

import errno
import os
from io import StringIO

import pytest
from rich.console import Console

from avahazard.cli.output import number, show_error, table


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
    assert number(value) == text


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
