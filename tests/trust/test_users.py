"""Many users for a moment, in threads; `make trust` has them in processes, and for longer."""

from __future__ import annotations

from pathlib import Path

from benchmarks.trust.users import large_imports, mix


def test_many_users_lose_nothing(any_database: str, tmp_path: Path) -> None:
    found = mix("here", any_database, tmp_path, 1.5, threads=True)
    assert found.faults == []
    assert found.lost == 0
    assert all(found.turns[role] > 0 for role in ("import", "update", "read"))


def test_imports_at_once_lose_nothing(any_database: str, tmp_path: Path) -> None:
    found = large_imports("here", any_database, tmp_path, 4, 400, threads=True)
    assert found.faults == []
    assert (found.lost, found.turns["import"]) == (0, 4)
