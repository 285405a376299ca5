"""The keys on the page of results are those of the documents that the commands print."""

from __future__ import annotations

import json
import re
import shutil
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from avahazard.cli.main import COMMANDS, app
from avahazard.results.base import plain
from avahazard.results.comparison import Comparison
from avahazard.results.hazard import HazardRow, ZonedPath
from avahazard.store.results import BOUNDS, COMPARISON, ZONES, latest_documents, latest_result
from avahazard.store.session import reading
from tests.criticism.lengths import as_csv, lengths

pytestmark = pytest.mark.usefixtures("drawn_little")

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "results.md").read_text(encoding="utf-8")
TOP = ("the document", "each entry", "each row")
Keys = dict[str, dict[str, bool]]


def sections() -> dict[str, Keys]:
    """By command: the keys of each object by its path ("" the document); true if always there."""
    found = {}
    for section in PAGE.split("\n## ")[1:]:
        keys: Keys = defaultdict(dict)
        for row in re.findall(r"^\| (.+?) \| (`.+?|\(`.+?) \|", section, re.MULTILINE):
            objects = [""] if row[0] in TOP else re.findall(r"`([^`]+)`", row[0])
            for optional, key in re.findall(r"(\(?)`([^`]+)`", row[1]):
                for name in objects:
                    keys[name][key] = not optional
        for command in section.split("\n")[0].split(" {")[0].split(", "):
            found[command] = keys
    return found


DOCUMENTED = sections()


def objects(value: Any, keys: Keys, place: str = "") -> Iterator[tuple[str, set[str]]]:
    """Every object within `value` by its place, names that are data written as on the page."""
    if isinstance(value, list):
        for entry in value:
            yield from objects(entry, keys, place)
    elif isinstance(value, dict):
        general = next((key for key in keys[place] if key.isupper()), None)
        yield place, {general or key for key in value}
        for key, inner in value.items():
            yield from objects(inner, keys, f"{place}.{general or key}".removeprefix("."))


def check(command: str, *documents: Any) -> None:
    """Fail where a document has a key that the page does not name, or lacks one that it names."""
    keys = DOCUMENTED[command]
    for document in documents:
        for place, real in objects(plain(document), keys):
            needed = {key for key, always in keys[place].items() if always}
            assert real <= keys[place].keys(), f"{command}, {place}: not on the page"
            assert real >= needed, f"{command}, {place}: not in the document"


@pytest.fixture
def on() -> Callable[..., Any]:
    """Give a function that runs the command line on a database and reads its document."""

    def run(database: str, *words: str) -> Any:
        done = CliRunner().invoke(app, ["--db", database, "--json", *words])
        assert done.exit_code == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_every_command_has_its_section() -> None:
    assert COMMANDS.keys() == DOCUMENTED.keys()


def test_the_loop(database: str, write: Callable[[str, str], Path], on: Any) -> None:
    events = str(write("events.csv", as_csv(lengths(30, 0.3, n_columns=1))))
    check("import", on(database, "import", events))
    words = ("--law", "power", "--chains", "2", "--draws", "60")
    check("calibrate", on(database, "calibrate", "base", *words))
    check("compare", on(database, "compare", "base"))
    check("diagnose", on(database, "diagnose", "base"))
    child = on(database, "add", "base", "covariate:column_1", "--as", "child")
    assert child["comparison"]["before"] is not None
    check("add", child)
    check("model", on(database, "model", "child"))
    check("rerun", on(database, "rerun", "base"))
    check("ladder", on(database, "ladder"))
    found = on(database, "predict", "child", events)
    assert found["events"]
    check("predict", found)
    check("fit", on(database, "fit"))


def test_a_path_and_its_bounds(report_database: str, tmp_path: Path, on: Any) -> None:
    file = str(shutil.copy(report_database, tmp_path / "copy.db"))
    with reading(file) as session:
        rows = latest_documents(session, BOUNDS, "m")
        zones = latest_documents(session, ZONES, "m")
        compared = latest_result(session, COMPARISON, "m")
    assert rows
    assert zones
    assert any("design" in row for row in rows)
    check("hazard", [HazardRow.from_dict(row) for row in rows])
    check("zones", [ZonedPath.from_dict(entry) for entry in zones])
    check("compare", Comparison.from_dict(compared))
    check("runout", on(file, "runout", "scey", "--mu", "0.4"))
    check("runout", on(file, "runout", "scey", "--model", "m", "--volume", "20000", "--table"))
    for name in ("scey", "saugy", "nants"):
        check("path", on(file, "path", name))
    for command in ("friction", "volumes", "alpha-beta", "paths", "models", "effects"):
        check(command, on(file, command))
    check("friction", on(file, "friction", "scey", "--model", "m"))
    check("effect", on(file, "effect", "forest-drag"))
    check("report", on(file, "report", "m", "-o", str(tmp_path / "m.html")))
    check("export", on(file, "export", "m", "-o", str(tmp_path / "m.csv")))


def test_databases_and_worlds(tmp_path: Path, on: Any) -> None:
    file = str(tmp_path / "new.db")
    check("init", on(file, "init"))
    for word in ("status", "check", "upgrade"):
        check("db", on(file, "db", word))
    check("db", on(file, "db", "backup", str(tmp_path / "copy.db")))
    check("synth", on(file, "synth", str(tmp_path / "world"), "--events", "6", "--paths", "1"))
