"""`avahazard compare`."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.commands.snow import document, refused, run
from tests.telling import untold

pytestmark = pytest.mark.usefixtures("drawn_little")


def test_people_and_programs(snow_database: str, tmp_path: Path) -> None:
    picture = tmp_path / "where.png"
    found = document(snow_database, "compare", "base", "--plot", str(picture))
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert set(found) >= {"model", "scores", "held_out", "where_it_fails"}
    done = run(snow_database, "compare", "base")
    assert done.exit_code == 0
    runout = found["scores"]["runout"]
    assert untold(done.stdout, f"{runout['rmse_m']:.1f}", f"{runout['noise_floor_m']:.0f} m") == []
    assert untold(done.stdout, "snow type", "wet", "fails beyond chance") == []
    events = [event["profile_m"] for event in found["budget_by_event"]]
    assert found["profile_m"] == pytest.approx(
        sum(m * m for m in events) ** 0.5 / len(events) ** 0.5
    )
    assert untold(" ".join(done.stdout.split()), f"by {found['profile_m']:.1f} m (rms)") == []
    lines = [x for x in done.stdout.splitlines() if not x.startswith("  avahazard")]
    assert max(map(len, lines)) <= 80


def test_what_cannot_be_compared(snow_database: str, tmp_path: Path) -> None:
    assert untold(refused(snow_database, "compare", "other"), "model other") == []
    said = refused(snow_database, "compare", "base", "--plot", str(tmp_path / "a.txt"))
    assert "not the name of a picture" in said
    said = refused(snow_database, "compare", "base", "--effect-file", str(tmp_path / "no.py"))
    assert "cannot be read" in said
    refused(snow_database, "compare", status=2)
