"""Progress on standard error."""

from __future__ import annotations

import json
import sys
from io import StringIO
from pathlib import Path

import pytest

from avahazard import progress


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
            report("sampling", i / 10)
    assert isinstance(sys.stderr, StringIO)
    assert sys.stderr.getvalue() == ""


def test_a_log_gets_a_line_now_and_then_with_the_time_left(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with progress.show_progress() as report:
        for i in range(20):
            report("sampling", i / 20)
            clock[0] += 1.0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == ["sampling: 10%, 18 s left", "sampling: 60%, 8 s left"]


def test_a_terminal_gets_a_bar(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.show_progress() as report:
        for i in range(5):
            report("sampling", i / 5)
            clock[0] += 1.0
    assert "sampling" in terminal.getvalue()


def test_one_bar_for_all_that_is_done(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.show_progress() as report:
        for i, what in enumerate(["reading", "sampling", "sampling", "writing", "writing"]):
            report(what, i / 5)
            clock[0] += 2.0
        text = terminal.getvalue()
    assert "100 %" not in text
    # A bar is one line: what is done takes the place of what was.
    assert not any("sampling" in line and "writing" in line for line in text.splitlines())


def test_the_time_left_is_not_told_before_it_is_known(
    clock: list[float], capsys: pytest.CaptureFixture[str]
) -> None:
    with progress.show_progress() as report:
        for share in (0.0, 0.02, 0.05, 0.2):
            report("sampling", share)
            clock[0] += 10.0
        # Another step has the rest of the bar, and is timed by itself.
        report("more", 0.0)
        clock[0] += 10.0
        report("more", 0.5)
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "sampling: 2%",
        "sampling: 5%",
        "sampling: 20%, 120 s left",
        "more: 20%",
        "more: 60%, 10 s left of this step",
    ]


RUNS = json.loads((Path(__file__).parent / "recorded_progress.json").read_text(encoding="utf-8"))
"""By command and data set: seconds and shares as they were reported, and when it ended."""
A_MOMENT_S = 2.5


@pytest.mark.parametrize("name", RUNS)
def test_the_bar_of_recorded_runs_is_monotone_and_its_time_left_true(
    name: str, clock: list[float]
) -> None:
    """After a tenth of the work within a factor of two, or a moment."""
    run, teller, last = RUNS[name], progress.Clock(), 0.0
    begin = clock[0]
    teller.tell(0.0)
    for seconds, share in run["told"]:
        clock[0] = begin + seconds
        shown, words = teller.tell(share)
        assert shown >= last
        last = shown
        if words and "step" not in words:
            said, left = float(words.split()[0]), run["ended"] - seconds
            assert abs(said - left) <= A_MOMENT_S or 0.5 <= said / left <= 2.0, (seconds, share)
