"""Records that tell next to nothing, before every command."""

from __future__ import annotations

from pathlib import Path

import pytest
from _pytest.mark import ParameterSet

from avahazard.workflow.calibrate import show_model
from benchmarks.trust.answers import SETS, run_set


def slow(*given: str) -> ParameterSet:
    return pytest.param(*given, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("name", "note"),
    [
        ("one event", "m is based on 1 event only."),
        slow("all beyond the profile", "log sigma is weakly identified"),
        slow("all volumes equal", "n in 1e-6/m3 is weakly identified"),
    ],
)
def test_commands_bear_them_and_say_so(name: str, note: str, database: str, tmp_path: Path) -> None:
    found = run_set(name, database, tmp_path, every=False)
    assert found.faults == []
    assert found.done > 0
    notes = show_model(database, "m").notes
    assert any(note in told for told in notes), notes


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
def test_every_command_bears_them(name: str, database: str, tmp_path: Path) -> None:
    assert run_set(name, database, tmp_path).faults == []
