"""Every way of writing the same events: read right and reported, or refused with a remedy."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from avahazard.records.collection import Path as AvalanchePath
from avahazard.records.collection import Records
from avahazard.records.conventions import UNKNOWN, Conventions
from avahazard.records.intake import Intake
from avahazard.records.reading import read_files
from tests.records.matrix import (
    DATES,
    ENCODINGS,
    HEADER,
    NUMBERS,
    ROWS,
    SEPARATORS,
    as_text,
    date_text,
    number_text,
    save_workbook,
)

KNOWN = Records(paths=(AvalanchePath("Aisté"),))


def read(file: Path, given: Conventions = UNKNOWN) -> Intake:
    """Read events of the path `Aisté`."""
    return read_files([file], KNOWN, given=given)


def values(intake: Intake) -> list[tuple[object, ...]]:
    """Return what was read in the order of `HEADER`."""
    return [
        (
            e.event_id,
            e.path_id,
            e.date,
            e.runout_x_m,
            e.volume_m3,
            e.covariates["slope"],
            e.covariates["snow_type"],
        )
        for e in intake.records.events
    ]


RIGHT = [(n, p, day.isoformat(), *rest) for n, p, day, *rest in ROWS]


@pytest.mark.parametrize(("separator", "numbers"), [*product(SEPARATORS, NUMBERS)])
def test_texts_are_read_right(tmp_path: Path, separator: str, numbers: str) -> None:
    for dates, encoding in product(DATES, ENCODINGS):
        file = tmp_path / "events.csv"
        file.write_bytes(as_text(separator, numbers, dates, encoding))
        found = read(file)
        assert found.problems == [], (dates, encoding)
        assert values(found) == RIGHT, (dates, encoding)
        (said,) = found.read
        assert {",": "commas", ";": "semicolons", "\t": "tabs"}[separator] in said
        assert ("decimal commas" in said) == (numbers in ("comma", "comma grouped", "french"))
        assert ("dates: " in said) == (dates != "iso")
        name = {"cp1252": "Windows-1252 (such as 'Aisté')"}.get(encoding, encoding.upper()[:6])
        assert name[:5] in said


@pytest.mark.parametrize("dates", ["cell", *DATES])
@pytest.mark.parametrize("numbers", ["cell", *NUMBERS])
@pytest.mark.parametrize("mac", [False, True])
def test_workbooks_are_read_right(tmp_path: Path, dates: str, numbers: str, mac: bool) -> None:
    if mac and dates == "serial":
        pytest.skip("day numbers of 1904 have a test of their own")
    rows = [
        (
            name,
            path,
            day if dates == "cell" else date_text(day, dates),
            *(v if numbers == "cell" else number_text(v, numbers) for v in rest),
            snow,
        )
        for name, path, day, *rest, snow in ROWS
    ]
    found = read(save_workbook(tmp_path / "events.xlsx", {"Sheet1": [HEADER, *rows]}, mac))
    assert found.problems == []
    assert values(found) == RIGHT


def test_day_numbers_of_a_workbook_count_from_its_own_first_day(tmp_path: Path) -> None:
    rows = [("event_id", "path_id", "date", "runout_x_m"), ("a", "Aisté", 20000, 300)]
    for mac, date in ((False, "1954-10-03"), (True, "1958-10-04")):
        found = read(save_workbook(tmp_path / "events.xlsx", {"S": rows}, mac))
        assert found.records.events[0].date == date


@pytest.mark.parametrize(
    ("text", "column", "remedy"),
    [
        ("event_id;path_id;runout_x_m\na;Aisté;1.234\n", "runout_x_m", "--decimal"),
        ("event_id;path_id;runout_x_m\na;Aisté;1,234\n", "runout_x_m", "--decimal"),
        ('event_id,path_id,runout_x_m\na,Aisté,"1,234"\n', "runout_x_m", "--decimal"),
        ("event_id;path_id;runout_x_m;s\na;Aisté;12.5;0,5\n", "s", "decimal point, as in line 2"),
        ("event_id,path_id,runout_x_m,date\na,Aisté,9,3/4/1950\n", "date", "--dates dmy"),
        ("event_id,path_id,runout_x_m,date\na,Aisté,9,3-4-1950\n", "date", "--dates dmy"),
        ("event_id,path_id,runout_x_m,date\na,Aisté,9,3.4.50\n", "date", "1950-02-13"),
        ("event_id,path_id,runout_x_m\na,Aisté,1,5\n", "", "in quotes"),
        ("event_id,path_id,runout_x_m,date\na,Aisté,9,18277\nb,Aisté,9,1905\n", "date", "day num"),
        ("event_id,path_id,runout_x_m,date\na,Aisté,9,31.02.1950\n", "date", "1950-02-13"),
        (
            "event_id,path_id,runout_x_m,date\na,Aisté,9,13/1/1950\nb,Aisté,9,14/1/1950\n"
            "c,Aisté,9,1/13/1950\n",
            "date",
            "one of them",
        ),
    ],
)
def test_what_may_be_read_in_two_ways_is_refused(
    tmp_path: Path, text: str, column: str, remedy: str
) -> None:
    file = tmp_path / "events.csv"
    file.write_text(text, encoding="utf-8")
    (problem,) = read(file).problems
    assert problem.column == column
    assert remedy in problem.accepted
    assert problem.line > 1


@pytest.mark.parametrize(
    ("given", "x", "date"),
    [
        (Conventions("point", "dmy"), 1.234, "1950-04-03"),
        (Conventions("comma", "mdy"), 1234.0, "1950-03-04"),
    ],
)
def test_the_remedy_works(tmp_path: Path, given: Conventions, x: float, date: str) -> None:
    file = tmp_path / "events.csv"
    file.write_text("event_id;path_id;runout_x_m;date\na;Aisté;1.234;3/4/1950\n", encoding="utf-8")
    found = read(file, given)
    assert not found.problems
    assert (found.records.events[0].runout_x_m, found.records.events[0].date) == (x, date)


def test_programs_write_points_between_commas(tmp_path: Path) -> None:
    """The plain form: 1.234 there is a number a little over one, as ever."""
    file = tmp_path / "events.csv"
    file.write_text("event_id,path_id,runout_x_m\na,Aisté,1.234\n", encoding="utf-8")
    assert read(file).records.events[0].runout_x_m == 1.234
