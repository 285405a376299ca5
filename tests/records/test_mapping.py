"""A `columns.toml` held against the tables that it is for."""

from pathlib import Path

import pytest
from openpyxl import Workbook

from avahazard.records.collection import Path as AvalanchePath
from avahazard.records.collection import Records
from avahazard.records.errors import AvahazardError
from avahazard.records.intake import Intake
from avahazard.records.mapping import read_mappings
from avahazard.records.reading import read_files

KNOWN = Records(paths=(AvalanchePath("Pra"),))
MAPPING = """
[[table]]
sheet = "Züge"
columns = {path_id = "Zug", name = "Name"}
[[table]]
sheet = "Ereignisse"
unknown = ["k.A."]
need = ["Auslauf"]
columns = {event_id = "Nr", path_id = "Zug", date = "Winter", runout_elevation_m = "Auslauf"}
"""


def read(folder: Path, mapping: str) -> Intake:
    """A workbook of two sheets that are mapped and one that is not."""
    book = Workbook()
    sheets = {
        "Züge": (("Zug", "Name"), ("Pra", "Prabach")),
        "Ereignisse": (
            ("Nr", "Zug", "Winter", "Auslauf"),
            ("a", "Pra", "1999", 1500),
            ("b", "Pra", "2000", "k.A."),
            ("c", "Pra", "2001", None),
        ),
        "Notizen": (("Text", "Wer"), ("ruhig", "hm")),
    }
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for row in rows:
            sheet.append(row)
    del book["Sheet"]
    book.save(folder / "Kataster.xlsx")
    (folder / "c.toml").write_text(mapping, encoding="utf-8")
    return read_files([folder / "Kataster.xlsx"], KNOWN, columns=folder / "c.toml")


@pytest.mark.parametrize(
    ("right", "wrong", "place", "column", "value", "accepted"),
    [
        ('"Winter"', '"Wintr"', ", table 2", "date", "Wintr", "Did you mean Winter?"),
        ('"Ereignisse"', '"Ereignis"', ", table 2", "sheet", "Ereignis", "Did you mean Ereig"),
        ('"Züge"', '"Blatt"', ", table 1", "sheet", "Blatt", "Züge, Ereignisse, Notizen"),
        ('"Name"', '"?"', ", table 1", "name", "?", "sheet Züge: Zug, Name"),
        ('["Auslauf"]', '["Auslaf"]', ", table 2", "need", "Auslaf", "Did you mean Auslauf?"),
    ],
)
def test_a_mapping_that_fits_no_table_is_refused_at_its_place(
    tmp_path: Path, right: str, wrong: str, place: str, column: str, value: str, accepted: str
) -> None:
    found = read(tmp_path, MAPPING.replace(right, wrong))
    (problem,) = found.problems
    assert problem.file == f"{tmp_path / 'c.toml'}{place}"
    assert (problem.column, problem.value) == (column, value)
    assert accepted in problem.accepted


def test_what_is_needed_is_not_there_where_it_is_unknown(tmp_path: Path) -> None:
    found = read(tmp_path, MAPPING)
    assert not found.problems
    assert [event.event_id for event in found.records.events] == ["a"]
    assert any("sheet Notizen: not read" in note for note in found.notes)


def test_what_a_mapping_lacks_of_a_form_is_asked_of_it(tmp_path: Path) -> None:
    found = read(tmp_path, MAPPING.replace('path_id = "Zug", date', "date"))
    (problem,) = found.problems
    assert problem.accepted == f"a column path_id in {tmp_path / 'c.toml'}, table 2"


def test_mappings_for_other_files_are_named(tmp_path: Path) -> None:
    other = '[[table]]\nfile = "Profile.csv"\ncolumns = {path_id = "Zug", x_m = "X", y_m = "Y"}\n'
    found = read(tmp_path, MAPPING + other)
    assert not found.problems
    assert any("c.toml, table 3: not used" in note for note in found.notes)
    alone = read(tmp_path, other)
    assert [(p.column, p.value) for p in alone.problems] == [("file", "Profile.csv")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("unknwon = []", "unknwon: there is no such key .* Did you mean unknown?"),
        ('[columns]\na = {from = "A", unti = "m"}', "columns, a, unti: there is no such key"),
        ('[columns]\nunknown = ["?"]', r"columns, unknown: this key stands above \[columns\]"),
        ('range = "mean"', "range: this key does not stand here"),
    ],
)
def test_keys_that_are_none_are_named(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "columns.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(AvahazardError, match=message):
        read_mappings(file)


def test_a_mapping_may_only_say_how_a_table_is_written(tmp_path: Path) -> None:
    file = tmp_path / "events.csv"
    file.write_text("event_id;path_id;runout_elevation_m;volume_m3\na;Pra;900;1,500\n")
    (problem,) = read_files([file], KNOWN).problems
    assert 'decimal = "comma" (or "point") in a columns.toml' in problem.accepted
    (tmp_path / "columns.toml").write_text('decimal = "comma"', encoding="utf-8")
    assert read_files([file], KNOWN).records.events[0].volume_m3 == 1.5
