"""One volume a thousand times the next: a slip of units is named, and no traceback."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import Result

from avahazard.records.collection import Records
from tests.criticism.lengths import as_csv, lengths


@pytest.mark.parametrize(
    "law", ["power", "exponential", pytest.param("rational", marks=pytest.mark.slow)]
)
def test_a_slip_of_units(
    avahazard: Callable[..., Result], write: Callable[[str, str], Path], law: str
) -> None:
    events = list(lengths(40, 0.0, n_columns=1).events)
    largest = max(event.volume_m3 or 0.0 for event in events)
    events[7] = replace(events[7], volume_m3=1000.0 * largest)
    done = avahazard("import", str(write("events.csv", as_csv(Records(events=tuple(events))))))
    assert "volume of e7" in done.stderr
    words = ("--law", law, "--chains", "2", "--draws", "60")
    done = avahazard("calibrate", "base", *words)
    assert done.exit_code == 0, done.output
    done = avahazard("--json", "diagnose", "base")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["suspect_events"][0] == "e7"
