"""Columns guessed from names, units and contents; what stays open is listed."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.records.guess import as_toml, guess_tables
from avahazard.records.mapping import read_mappings
from avahazard.records.reading import read_records
from avahazard.records.sheet import read_tables
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
    written = tmp_path / "columns.toml"
    written.write_text(as_toml([(file.name, found)]), encoding="utf-8")
    (mapping,) = read_mappings(written).values()
    assert mapping.header == 3
    assert next(iter(mapping.needed())) == "Nr"


def test_words_of_an_office_for_known_values_are_translated(tmp_path: Path) -> None:
    """A forest called Wald was an effect that could not be found, without a word."""
    ground = tmp_path / "Profile.csv"
    ground.write_text(
        "Zug,Distanz (m),Höhe (m),Bodenbedeckung\n"
        "A,0,2000,offen\nA,500,1500,Wald\nA,900,1300,Fels\n",
        encoding="utf-8",
    )
    rows = "".join(f"{k},A,1950,1350,{'ja' if k < 3 else 'nein'},steil\n" for k in range(1, 30))
    events = tmp_path / "events.csv"
    events.write_text(
        f"Nr,Zug,Jahr,Auslaufhöhe (m),Über Profilende,Bemerkungen\n{rows}29 Lawinen,,,,,\n",
        encoding="utf-8",
    )
    written = guess_columns([events, ground])
    classes = {guess.column: guess.classes for guess in written.guesses}
    assert classes["land_cover"] == {"offen": "open", "Wald": "forest"}
    assert classes["left_profile"] == {"ja": "1", "nein": "0"}
    said = "\n".join(written.open)
    assert "'Bodenbedeckung' has 'Fels', which is not forest or open" in said
    assert "left out (not in keep): 'Bemerkungen'" in said
    assert "1 row without 'Zug' left out (need)" in said
    of_events, of_ground = read_mappings(Path(written.written)).values()
    assert of_events.need == ["Zug"]
    assert of_events.keep == []
    assert of_ground.columns["land_cover"].classes == classes["land_cover"]


def test_events_with_h_and_l_need_no_path(tmp_path: Path) -> None:
    rows = "".join(f"{k},{'A' if k > 1 else ''},500,1200\n" for k in range(1, 40))
    file = tmp_path / "slides.csv"
    file.write_text(f"Nr,Zug,H (m),L (m)\n{rows}", encoding="utf-8")
    ((found,), _) = guess_tables(file)
    assert {"path_id", "fall_height_m"} <= {guess.column for guess in found.guesses}
    assert not found.need


def test_a_mapping_is_never_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "slides.csv"
    file.write_text("Name,H (m),L (m)\na,500,1200\n", encoding="utf-8")
    written = guess_columns([file])
    assert {guess.column for guess in written.guesses} >= {"fall_height_m", "runout_length_m"}
    with pytest.raises(AvahazardError, match="is there already"):
        guess_columns([file])
    (tmp_path / "words.csv").write_text("foo,bar\n1,2\n", encoding="utf-8")
    Path(written.written).unlink()
    with pytest.raises(AvahazardError, match="No column of"):
        guess_columns([tmp_path / "words.csv"])


def test_tables_of_one_folder_have_one_mapping(tmp_path: Path) -> None:
    events, profiles = tmp_path / "events.csv", tmp_path / "Profile.csv"
    events.write_text("Nr;Lawinenzug;Jahr;Höhe\n1;Pra;1999;1200\n", encoding="utf-8")
    profiles.write_text(
        "Nr;Lawinenzug;Distanz (m);Höhe (m)\n1;Pra;0,0;2400,5\n2;Pra;10,5;2391,0\n",
        encoding="utf-8",
    )
    found = guess_columns([events, profiles])
    assert [(g.table, g.column) for g in found.guesses if g.column in ("x_m", "y_m")] == [
        (str(profiles), "x_m"),
        (str(profiles), "y_m"),
    ]
    of_events, of_profiles = read_mappings(Path(found.written)).values()
    assert "Nr" in of_events.needed()
    # The number of a point names no event.
    assert sorted(of_profiles.needed()) == ["Distanz (m)", "Höhe (m)", "Lawinenzug"]
    (tmp_path / "elsewhere").mkdir()
    other = tmp_path / "elsewhere" / "more.csv"
    other.write_text(events.read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(AvahazardError, match="in another folder"):
        guess_columns([events, other])


def test_decimal_commas_are_no_separators(tmp_path: Path) -> None:
    file = tmp_path / "unknown.csv"
    file.write_text("Nummer;Wert;Zahl\nA;1,5;2,5\nB;3,5;4,5\n", encoding="utf-8")
    (table,) = read_tables(file, [])
    assert table.header == ("Nummer", "Wert", "Zahl")


def test_a_folder_has_one_mapping_with_ranges_and_words_and_a_table_of_paths(
    tmp_path: Path,
) -> None:
    files = {
        "Ereignisse": "Nr.;Lawinenzug;Datum;Auslaufhöhe (m);Volumen (m³)\n"
        "1;Pra;02.03.1999;1500;1000-4000\n",
        "Züge": "Lawinenzug;Gemeinde;Beobachtet von;Einzugsgebiet (ha)\nPra;Ort;1900;10,5\n",
        "Profile": "Lawinenzug;Distanz (m);Höhe (m);Bodenbedeckung\n"
        "Pra;0,0;2400,5;offen\nPra;500,0;1900,5;Wald\nPra;1500,0;1400,5;Wald\n"
        "Pra;1800,0;1350,5;offen\nPra;2000,0;1330,5;offen\n",
    }
    for name, text in files.items():
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    written = Path(guess_columns([tmp_path]).written)
    text = written.read_text(encoding="utf-8")
    assert "{row}" not in text  # no table has events without a number
    assert 'range = "geometric"' in text
    assert "observed_from" in text
    assert "catchment_ha" in text
    assert 'classes = {"offen" = "open", "Wald" = "forest"}' in text
    records = read_records([tmp_path])
    assert records.profiles[0].land_cover == ("open", "forest", "forest", "open", "open")
    assert records.events[0].volume_m3 == 2000.0


@pytest.mark.parametrize(
    ("header", "cells", "columns"),
    [
        (
            "N° fiche;Zug-Nr.;Winter;Anriss (m ü. M.);Auslauf (m ü. M.)",
            "F1;Z1;1999;2400;1500",
            "event_id path_id date release_elevation_m runout_elevation_m",
        ),
        ("ID;Path;Deposit volume (cu yd)", "a;P;10", "event_id path_id volume_m3"),
        (
            "Couloir;Distance (m);Altitude (m);Couverture",
            "P;0;2000;x",
            "path_id x_m y_m land_cover",
        ),
    ],
)
def test_headers_of_offices(tmp_path: Path, header: str, cells: str, columns: str) -> None:
    file = tmp_path / "k.csv"
    file.write_text(f"{header}\n{cells}\n", encoding="utf-8")
    ((found,), _) = guess_tables(file)
    by_source = {guess.source: guess.column for guess in found.guesses}
    assert [by_source.get(name) for name in header.split(";")] == columns.split()
    lacks_a_stop = any("no column seems to be runout_x_m" in text for text in found.open)
    assert lacks_a_stop == ("volume_m3" in columns)


def test_what_is_required_and_what_a_header_may_also_be_is_open(tmp_path: Path) -> None:
    file = tmp_path / "k.csv"
    file.write_text("Nr;Datum;Auslauf (m)\n1;1999;400-500\n", encoding="utf-8")
    ((found,), _) = guess_tables(file)
    said = "\n".join(found.open)
    assert "'Auslauf (m)' may also be runout_x_m" in said
    assert "no column seems to be path_id, which is required" in said
    assert 'range = "mean"' in said
