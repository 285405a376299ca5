"""Columns guessed from names, units and contents; what stays open is listed."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.records.guess import as_toml, guess_tables
from avahazard.records.mapping import read_mappings
from avahazard.workflow.database import guess_columns


def test_each_guess_has_its_reason_and_the_rest_is_open(tmp_path: Path) -> None:
    file = tmp_path / "Kataster.csv"
    file.write_text(
        "Kataster 2020;;;;\n\nNr;Lawinenzg;Anrisshöhe (ft);Volumen [km3];Volumen (m³);Länge;"
        "Fallhöhe;Datum\n1;Pra;8000;1;5000;2,1;700;keines\n2;Pra;8100;2;6000;3,5;800;auch\n",
        encoding="utf-8",
    )
    ((found,), problems) = guess_tables(file)
    assert not problems
    assert found.layout.header == 3
    by_column = {guess.column: guess for guess in found.guesses}
    assert by_column["release_elevation_m"].unit == "ft"
    assert "in ft" in by_column["release_elevation_m"].reason
    near = by_column["path_id"]
    assert near.source == "Lawinenzg"
    assert near.confidence < by_column["event_id"].confidence
    assert "date" not in by_column  # its cells are no dates
    said = "\n".join(found.open)
    assert "is volume_m3: which one?" in said
    assert "'Länge' is mostly below 'Fallhöhe': is it in km?" in said
    assert "the unit of 'Länge' is not said" in said
    (mapping,) = read_mappings(Path("columns.toml"), as_toml(file, [found]))
    assert mapping.header == 3
    assert mapping.needed()[0] == "Nr"


def test_a_mapping_is_never_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "slides.csv"
    file.write_text("Name,H (m),L (m)\na,500,1200\n", encoding="utf-8")
    written = guess_columns(file)
    assert {guess.column for guess in written.guesses} >= {"fall_height_m", "runout_length_m"}
    with pytest.raises(AvahazardError, match="is there already"):
        guess_columns(file)
    (tmp_path / "words.csv").write_text("foo,bar\n1,2\n", encoding="utf-8")
    Path(written.written).unlink()
    with pytest.raises(AvahazardError, match="No column of"):
        guess_columns(tmp_path / "words.csv")
