"""What a process has taken, and what is left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avahazard.engine import memory


def test_the_peak_grows_with_what_is_taken() -> None:
    before = memory.peak_bytes()
    taken = np.ones(before // 8 + 10_000_000)
    assert memory.peak_bytes() > before + 40_000_000
    del taken


def test_a_container_has_what_its_limit_leaves(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    files = {"LIMIT": "5000\n", "USED": "3000\n", "STAT": "inactive_file 500\nactive_file 100\n"}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
        monkeypatch.setattr(memory, name, tmp_path / name)
    assert memory.free_bytes() == 5000 - (3000 - 600)
    (tmp_path / "LIMIT").write_text("max\n")
    whole = memory.free_bytes()
    assert whole is None or whole > 1_000_000
