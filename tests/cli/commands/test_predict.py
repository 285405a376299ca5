"""`avahazard predict`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.cli.commands.snow import document, refused, run

KEYS = {"event_id", "path_id", "mean_m", "sd_m", "q05_m", "q50_m", "q95_m", "p_left_profile"}


def test_rows_or_rows_with_scores(snow_database: str, snow_world: Path, write: Any) -> None:
    new = write("new.csv", "event_id,path_id,volume_m3\nnext,P01,30000\n")
    (row,) = document(snow_database, "predict", "base", str(new))
    assert set(row) >= KEYS
    known = snow_world / "world" / "events.csv"
    found = document(snow_database, "predict", "base", str(known))
    assert set(found) == {"events", "scores"}
    assert found["scores"]["runout"]["n"] == len(found["events"]) == 120
    table = run(snow_database, "predict", "base", str(known)).stdout
    assert "P01-001" in table
    assert "Scores against the records" in table
    assert max(map(len, table.splitlines())) <= 80


def test_bad_input(snow_database: str, write: Any, tmp_path: Path) -> None:
    bad = write("bad.csv", "event_id,path_id,volume_m3\nnext,P01,many\n")
    said = refused(snow_database, "predict", "base", str(bad))
    assert "volume_m3" in said
    assert "many" in said
    assert refused(snow_database, "predict", "base", str(tmp_path / "no.csv"))
    refused(snow_database, "predict", "base", status=2)
