"""`avahazard import`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from avahazard.store.records import load_records
from avahazard.store.session import reading
from tests.records.matrix import save_workbook

Run = Callable[..., Result]
Write = Callable[[str, str], Path]

PROFILE = "path_id,x_m,y_m\n" + "".join(f"P,{100 * i},{1000 - 90 * i}\n" for i in range(6))
EVENTS = "event_id,path_id,runout_elevation_m,volume_m3\na,P,700,5000\nb,P,650,9000\n"


@pytest.fixture
def folder(write: Write) -> Path:
    """Give a folder with a profile and two events."""
    write("profiles.csv", PROFILE)
    return write("events.csv", EVENTS).parent


def counts(done: Result) -> dict[str, tuple[int, int, int]]:
    """Return new, unchanged and updated by kind."""
    assert done.exit_code == 0, done.output
    return {kind: tuple(n.values()) for kind, n in json.loads(done.stdout)["records"].items()}


def n_events(database: str) -> int:
    """Return how many events are stored."""
    with reading(database) as session:
        return len(load_records(session).events)


def test_import_twice(avahazard: Run, folder: Path) -> None:
    assert counts(avahazard("--json", "import", str(folder))) == {
        "paths": (1, 0, 0),
        "profiles": (1, 0, 0),
        "events": (2, 0, 0),
        "speeds": (0, 0, 0),
    }
    assert counts(avahazard("--json", "import", str(folder)))["events"] == (0, 2, 0)
    done = avahazard("import", str(folder))
    assert done.exit_code == 0
    *lines, step = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert step.endswith(" calibrate base")
    assert "Next" not in avahazard("import", str(folder), "--dry-run").stdout


def test_a_contradiction_needs_update(
    avahazard: Run, folder: Path, write: Write, database: str
) -> None:
    avahazard("import", str(folder))
    changed = write("events.csv", EVENTS.replace("9000", "8000") + "c,P,640,1\n")
    done = avahazard("--json", "import", str(changed))
    assert (done.exit_code, done.stdout) == (1, "")
    assert "9000" in done.stderr
    assert "--update" in done.stderr
    assert n_events(database) == 2
    assert counts(avahazard("--json", "import", "--update", str(changed)))["events"] == (1, 1, 1)
    assert n_events(database) == 3


def test_a_dry_run_stores_nothing(avahazard: Run, folder: Path, database: str) -> None:
    done = avahazard("--json", "import", "--dry-run", str(folder))
    assert counts(done)["events"] == (2, 0, 0)
    assert json.loads(done.stdout)["dry_run"] is True
    assert n_events(database) == 0
    assert "nothing was stored" in avahazard("import", "--dry-run", str(folder)).stdout


def test_all_or_nothing_and_every_bad_row_is_listed(
    avahazard: Run, folder: Path, write: Write, database: str
) -> None:
    write("events.csv", EVENTS + "c,Z,700,5\nd,P,700,-5\n,P,700,\n")
    done = avahazard("import", str(folder))
    assert (done.exit_code, done.stdout) == (1, "")
    shown = " ".join(done.stderr.split())
    for word in ("events.csv", "4 path_id Z", "5 volume_m3 -5", "6 event_id", "3 values are not"):
        assert word in shown
    with reading(database) as session:
        assert load_records(session).paths == ()


def test_a_missing_source(avahazard: Run, tmp_path: Path) -> None:
    done = avahazard("import", str(tmp_path / "none.csv"))
    assert (done.exit_code, done.stdout) == (1, "")
    assert "no file or folder" in done.stderr


def test_unused_columns_are_noted_on_standard_error(avahazard: Run, write: Write) -> None:
    file = write("profiles.csv", PROFILE.replace("y_m\n", "y_m,cover\n").replace("0\n", "0,\n"))
    done = avahazard("--json", "import", str(file))
    assert json.loads(done.stdout)["notes"]
    assert "cover" in done.stderr


def test_all_real_data_are_imported(avahazard: Run, shared_data: Path) -> None:
    folders = [
        str(shared_data / f) for f in ("avanodes", "tyrol-profiles", "rock-avalanches-canada")
    ]
    for expected in ((53, 0), (0, 53)):
        done = avahazard("--json", "import", *folders)
        events = json.loads(done.stdout)["records"]["events"]
        assert (events["new"], events["unchanged"]) == expected


def test_a_dry_run_shows_how_each_column_is_read(avahazard: Run, folder: Path) -> None:
    (folder / "events.csv").write_bytes(
        "Event ID;path_id;Date;runout_elevation_m;Volume (m³);Bemerkung\n"
        "a;P;14.01.1950;700,5;5000;naß\n".encode("cp1252")
    )
    done = avahazard("import", "--dry-run", str(folder))
    assert done.exit_code == 0, done.stderr
    shown = " ".join(done.stdout.split())
    for words in (
        "Date date: date, or year 1950-01-14",
        "runout_elevation_m elevation of the stop m a.s.l. 700.5",
        "Volume (m³) volume_m3: volume of the deposit m3 5000",
        "Bemerkung your own column, words naß",
    ):
        assert words in shown
    assert max(map(len, done.stdout.splitlines())) <= 80
    told = next(line for line in done.stderr.splitlines() if "events.csv" in line)
    for words in (
        "events, 1 row",
        "Windows-1252 (such as 'naß')",
        "semicolons",
        "decimal commas",
        "dates: dd.mm.yyyy (14.01.1950 is 1950-01-14)",
        "Event ID is event_id, Date is date, Volume (m³) is volume_m3",
    ):
        assert words in told
    read = json.loads(avahazard("--json", "import", "--dry-run", str(folder)).stdout)["understood"]
    assert [c["values"] for c in read if c["column"] == "Date"] == [["1950-01-14"]]


def test_the_remedies_are_options(avahazard: Run, folder: Path) -> None:
    (folder / "events.csv").write_text(
        "event_id;path_id;date;runout_x_m;runout_elevation_m\na;P;3/4/1950;100,125;\n"
    )
    done = avahazard("import", str(folder))
    assert done.exit_code == 1
    shown = " ".join(done.stderr.split())
    assert "--decimal" in shown
    assert "--dates dmy" in shown
    done = avahazard("import", "--decimal", "comma", "--dates", "dmy", str(folder))
    assert done.exit_code == 0, done.stderr
    assert avahazard("import", "--dates", "ymd", str(folder)).exit_code == 2


def test_a_volume_that_dwarfs_the_rest_is_named(avahazard: Run, write: Write) -> None:
    head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
    rows = "".join(f"e{i},500,{900 + i},{2e4 + i}\n" for i in range(8))
    done = avahazard("import", str(write("events.csv", f"{head}{rows}x,500,950,5e7\n")))
    assert done.exit_code == 0
    assert "volume of x, 5e+07 m3, dwarfs" in " ".join(done.stderr.split())


def test_a_workbook_beside_tables_is_read_or_refused(avahazard: Run, folder: Path) -> None:
    rows = [tuple(line.split(",")) for line in EVENTS.splitlines()]
    save_workbook(folder / "events.xlsx", {"Sheet1": rows})
    done = avahazard("import", str(folder))
    assert done.exit_code == 1
    assert "events.csv and events.xlsx" in done.stderr
    (folder / "events.csv").unlink()
    assert counts(avahazard("--json", "import", str(folder)))["events"] == (2, 0, 0)


def test_an_avalanche_in_two_lists_is_noted_once_both_are_there(
    avahazard: Run, write: Write
) -> None:
    head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
    rows = "".join(f"e{i},500,{900 + i},{2e4 + i}\n" for i in range(3))
    done = avahazard("import", str(write("first.csv", f"{head}{rows}")))
    assert "recorded twice" not in " ".join(done.stderr.split())
    done = avahazard("import", str(write("second.csv", f"{head}f1,500,901,20001\n")))
    assert done.exit_code == 0
    assert "e1 = f1: alike in path" in " ".join(done.stderr.split())
