"""Locked versions against advisories: which are affected, and what was never held."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks.advisories import KEPT, LOCKS, ROOT, affects, faults_of, held, pins

ADVISORY = """\
id: PYSEC-2030-7
aliases: [CVE-2030-1]
affected:
- package: {name: Snow.Pit, ecosystem: PyPI}
  ranges:
  - {type: GIT, events: [{introduced: '0'}, {fixed: 0123abcd}]}
  - type: ECOSYSTEM
    events:
    - introduced: '2.0'
    - fixed: 2.4.1
  versions: ['1.7']
"""


def about(*events: dict[str, str], **more: Any) -> dict[str, Any]:
    part = {"package": {"name": "snow-pit"}, "ranges": [{"type": "ECOSYSTEM", "events": events}]}
    return {"id": "X", "affected": [part], **more}


@pytest.fixture(scope="module")
def database(tmp_path_factory: pytest.TempPathFactory) -> str:
    made = tmp_path_factory.mktemp("database")
    file = made / "vulns" / "snow-pit" / "PYSEC-2030-7.yaml"
    file.parent.mkdir(parents=True)
    file.write_text(ADVISORY)
    git = ["git", "-C", str(made), "-c", "user.name=x", "-c", "user.email=x@example.org"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "x"]):
        subprocess.run([*git, *words], check=True)
    return str(made)


def test_what_is_locked_was_held_and_is_not_affected() -> None:
    locked = pins((ROOT / name).read_text(encoding="utf-8") for name in LOCKS)
    assert sum(pin.startswith("numba==") for pin in locked) == 1
    assert faults_of(locked, json.loads(KEPT.read_text(encoding="utf-8"))) == []


def test_pins_of_all_locks_are_read_by_the_names_of_the_index() -> None:
    lock = (
        "Snow_Pit==2.4 ; python_full_version < '3.12' \\\n    --hash=sha256:aa\n    # via x\nb==1\n"
    )
    assert pins([lock, "b==2 \\\n"]) == ["b==1", "b==2", "snow-pit==2.4"]


@pytest.mark.parametrize(
    ("version", "affected"),
    [("1.7", True), ("1.8", False), ("2.0", True), ("2.4", True), ("2.4.1", False), ("10", False)],
)
def test_a_clone_tells_which_versions_are_affected(
    database: str, version: str, affected: bool
) -> None:
    kept = held([f"snow-pit=={version}"], database, {})
    assert kept["advisories"] == kept["of_packages"] == 1
    assert [one["id"] for one in kept["affected"]] == ["PYSEC-2030-7"] * affected
    faults = faults_of([f"snow-pit=={version}"], kept)
    assert len(faults) == affected
    for fault in faults:
        assert f"snow-pit=={version} is affected by PYSEC-2030-7, CVE-2030-1" in fault
        assert "fixed in 2.4.1" in fault


def test_what_is_borne_with_a_reason_is_no_fault(database: str) -> None:
    reasons = {"PYSEC-2030-7": "the part at fault is never called", "PYSEC-2029-1": "gone"}
    kept = held(["snow-pit==2.1"], database, reasons)
    assert kept["affected"]
    assert kept["borne"] == {"PYSEC-2030-7": "the part at fault is never called"}
    assert faults_of(["snow-pit==2.1"], kept) == []


def test_a_version_that_was_not_held_is_a_fault(database: str) -> None:
    kept = held(["snow-pit==3.0"], database, {})
    (fault,) = faults_of(["snow-pit==3.0", "snow-pit==3.1"], kept)
    assert fault.startswith("snow-pit==3.1 was not held")


@pytest.mark.parametrize(
    ("events", "inside", "outside"),
    [
        (({"introduced": "0"}, {"last_affected": "2.0"}), "2.0", "2.0.1"),
        (({"introduced": "0"}, {"limit": "2.0"}), "1.9", "2.0"),
        (({"introduced": "3"}, {"introduced": "0"}, {"fixed": "2"}, {"fixed": "4"}), "3.1", "2.5"),
        (({"introduced": "1.10"},), "1.11", "1.9"),
    ],
)
def test_ranges_end_where_they_say(
    events: tuple[dict[str, str], ...], inside: str, outside: str
) -> None:
    assert affects(about(*events), f"snow-pit=={inside}")
    assert not affects(about(*events), f"snow-pit=={outside}")


def test_other_packages_and_advisories_taken_back_do_not_count() -> None:
    every = {"introduced": "0"}
    assert affects(about(every), "snow-pit==1")
    assert not affects(about(every), "snow-pits==1")
    assert not affects(about(every, withdrawn="2030-01-01T00:00:00Z"), "snow-pit==1")


def test_a_folder_that_is_no_clone_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="git"):
        held(["snow-pit==1"], str(tmp_path / "none"), {})
