"""The printed next step, followed blindly: it ends at the best model and passes no worse one."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import Result

DATASETS = ((), ("snow-type",), ("season",), ("release-elevation",), ("path-section", "snow-type"))
"""The hidden effects of each dataset; the first has none. Seeds are 1 to 5."""
MOST_STEPS = 16
TOLERANCE = 0.02
"""Share of the held-out CRPS within which two models of 150 events count as equal."""


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "hidden"), list(enumerate(DATASETS, 1)))
def test_next_steps_lead_to_the_best_model(
    avahazard: Callable[..., Result],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    seed: int,
    hidden: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)

    def document(*words: str) -> Any:
        result = avahazard("--json", *words)
        assert result.exit_code == 0, f"{words}\n{result.stderr}"
        return json.loads(result.stdout)

    given = [word for key in hidden for word in ("--effect", key)]
    document("synth", "data", *given, "--events", "150", "--seed", str(seed))
    document("init")
    document("import", *(str(f) for f in sorted(Path("data").glob("*.csv"))))
    step = ("calibrate", "base")
    done: list[tuple[str, ...]] = []
    while step[0] != "hazard":
        assert step not in done, f"the same step comes again: {done}"
        done.append(step)
        assert len(done) <= MOST_STEPS, done
        words = shlex.split(document(*step)["next"])
        assert words[0] == "avahazard", (words, done)
        step = tuple(words[1:])

    error = {row["model"]: row["held_out_crps_m"] for row in document("ladder")}
    print(seed, hidden, done, step, error)
    children = [(words[1], words[words.index("--as") + 1]) for words in done if words[0] == "add"]
    for parent, child in children:
        assert error[child] <= (1.0 + TOLERANCE) * error[parent], (done, error)
    used = [word for word in step[1:] if word in error]
    assert used, (step, error)
    lowest = min(error.values())
    assert all(error[name] <= (1.0 + TOLERANCE) * lowest for name in used), (step, error)
