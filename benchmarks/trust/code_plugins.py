"""What the tests on changed code are run with: plug-ins of pytest."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import coverage
import pytest

ROOT = Path(__file__).resolve().parents[2]
COVERAGE = str(Path(coverage.__file__).parent)


class TooLongError(BaseException):
    """A test takes longer than it may."""


class Alone:
    """One thread does all: a thread that is stopped amid a test would be waited for for ever."""

    def pytest_configure(self) -> None:
        from avahazard.workers import set_workers  # noqa: PLC0415 (only once a change is in place)

        set_workers(1)


class Watch(Alone):
    """Notes which lines each test runs and how long it takes; stops those over `most_s`."""

    def __init__(self, folders: list[str], most_s: float) -> None:
        self.cover = coverage.Coverage(
            data_file=None, config_file=False, source=[str(ROOT / f) for f in folders]
        )
        self.most_s = most_s
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()
        self._began = 0.0

    def _stop(self, _signal: int, frame: FrameType | None) -> None:
        while frame is not None:
            if frame.f_code.co_filename.startswith(COVERAGE):
                # Stopped here it would keep its lock; a little later it is out of it.
                signal.setitimer(signal.ITIMER_PROF, 0.01)
                return
            frame = frame.f_back
        raise TooLongError

    @contextmanager
    def _watched(self, context: str) -> Iterator[None]:
        self.cover.switch_context(context)
        signal.signal(signal.SIGPROF, self._stop)
        signal.setitimer(signal.ITIMER_PROF, self.most_s)
        try:
            yield
        except TooLongError:
            pytest.fail("too long", pytrace=False)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            self.cover.switch_context("")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        began = time.process_time()
        result = yield
        self.seconds[item.nodeid] = time.process_time() - began
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        # What a file's or a session's fixtures run stands for all tests of the file.
        with self._watched(item.nodeid.partition("::")[0]):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        with self._watched(item.nodeid):
            return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if not report.passed:
            self.failed.add(report.nodeid)

    def covering(self) -> dict[str, dict[str, list[str]]]:
        """The tests, or files of tests, that run each line of each module; "" is an import."""
        data = self.cover.get_data()
        return {
            str(Path(file).relative_to(ROOT)): {
                str(line): names for line, names in data.contexts_by_lineno(file).items()
            }
            for file in data.measured_files()
        }


class Only(Alone):
    """Keeps these tests, in this order."""

    def __init__(self, tests: list[str]) -> None:
        self.place = {name: k for k, name in enumerate(tests)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted(
            (item for item in items if item.nodeid in self.place),
            key=lambda item: self.place[item.nodeid],
        )
