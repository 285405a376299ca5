"""Progress on standard error."""

from __future__ import annotations

import sys
from io import StringIO

import pytest

from avahazard.cli import progress


class Terminal(StringIO):
    """A standard error that is a terminal."""

    def isatty(self) -> bool:
        """Say so."""
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Give a clock that goes on only when the test says so."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


@pytest.mark.parametrize("stream", [StringIO, Terminal])
def test_short_things_show_nothing(
    clock: list[float], monkeypatch: pytest.MonkeyPatch, stream: type[StringIO]
) -> None:
    monkeypatch.setattr(sys, "stderr", stream())
    with progress.show_progress() as report:
        for i in range(10):
            clock[0] += 0.15
            report("sampling", i, 10)
    assert isinstance(sys.stderr, StringIO)
    assert sys.stderr.getvalue() == ""


def test_a_log_gets_a_line_now_and_then_with_the_time_left(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with progress.show_progress() as report:
        for i in range(20):
            report("sampling", i, 20)
            clock[0] += 1.0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == ["sampling: 10%, 18 s left", "sampling: 60%, 8 s left"]


def test_a_terminal_gets_a_bar(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.show_progress() as report:
        for i in range(5):
            report("sampling", i, 5)
            clock[0] += 1.0
    assert "sampling" in terminal.getvalue()
