"""The program as a whole."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from avahazard import __version__
from avahazard.cli.main import COMMANDS, app, help_of, load, main
from avahazard.notes import Note
from avahazard.results.base import Rows
from avahazard.results.friction import Fits
from avahazard.workflow.database import import_files

PROGRAM = Path(sys.executable).with_name("avahazard")


def test_the_installed_command_prints_its_version() -> None:
    done = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"avahazard {__version__}\n"


def test_common_options_may_stand_anywhere(database: str, tmp_path: Path) -> None:
    (tmp_path / "paths.csv").write_text("path_id\nP\n", encoding="utf-8")
    import_files(database, [tmp_path / "paths.csv"])
    first = CliRunner().invoke(app, ["--db", database, "--json", "paths"])
    assert json.loads(first.stdout)[0]["path_id"] == "P"
    for words in (["--db", database, "--json"], ["--json", "--verbose", f"--db={database}"]):
        assert CliRunner().invoke(app, ["paths", *words]).stdout == first.stdout
    last = CliRunner().invoke(app, ["paths", "--db"])
    assert last.exit_code == 2
    assert CliRunner().invoke(app, ["--db", database, "path", "--", "--json"]).exit_code == 1


@pytest.mark.parametrize("given", [None, "4"])
def test_linear_algebra_has_one_thread_unless_asked_for_more(
    given: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    if given is not None:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
    found: list[str | None] = []
    monkeypatch.setattr(
        "avahazard.cli.main.app", lambda **_: found.append(os.getenv("OPENBLAS_NUM_THREADS"))
    )
    main()
    assert found == [given or "1"]


def loads_none_of(heavy: str, code: str) -> str:
    """What code prints in a new process, which loads none of these modules."""
    code = f"import sys\n{code}\nsys.exit(' '.join({{*{heavy.split()}}} & {{*sys.modules}}) or 0)\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_help_loads_none_of_the_heavy_libraries() -> None:
    code = (
        "from avahazard.cli.main import app\n"
        "try:\n    app(['--help'])\n"
        "except SystemExit:\n    pass"
    )
    heavy = "sqlalchemy alembic pandas numpy scipy numba pydantic matplotlib rich"
    said = " ".join(loads_none_of(heavy, code).split())
    assert all(help_of(name) in said for name in COMMANDS)


def test_help_of_commands_compiles_and_computes_nothing() -> None:
    code = "from avahazard.cli.main import COMMANDS, load\nfor name in COMMANDS:\n    load(name)"
    loads_none_of("numba scipy.stats sqlalchemy matplotlib", code)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_help_that_the_list_shows(name: str) -> None:
    command = load(name)
    assert command.name == name
    assert (command.help or "").splitlines()[0] == help_of(name)
    done = CliRunner().invoke(app, [name, "--help"])
    assert done.exit_code == 0
    assert help_of(name) in " ".join(done.stdout.split())


@pytest.mark.parametrize("name", COMMANDS.values())
def test_command_files_load_nothing_heavy_by_themselves(name: str) -> None:
    module = import_module(f"avahazard.cli.{name}")
    heavy = {"numpy", "pandas", "numba", "sqlalchemy", "workflow"}
    assert not heavy & vars(module).keys()


@pytest.mark.parametrize(
    "words", [[], ["nonsense"], ["--nonsense"], ["import"], ["db"], ["db", "backup"]]
)
def test_wrong_usage_ends_with_2(words: list[str]) -> None:
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert "Traceback" not in done.output


@pytest.mark.parametrize(
    "words", [["paths"], ["db", "status"], ["db", "check"], ["db", "upgrade"], ["import", "."]]
)
@pytest.mark.parametrize("as_json", [[], ["--json"]])
def test_a_missing_database_names_init(
    tmp_path: Path, words: list[str], as_json: list[str]
) -> None:
    done = CliRunner().invoke(app, ["--db", str(tmp_path / "no.db"), *as_json, *words])
    assert done.exit_code == 1
    assert done.stdout == ""
    assert "There is no database" in done.stderr
    assert "avahazard init" in done.stderr
    assert not (tmp_path / "no.db").exists()


def test_the_database_may_come_from_the_environment(
    database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AVAHAZARD_DB", database)
    assert CliRunner().invoke(app, ["db", "check"]).exit_code == 0


def test_errors_of_files_are_one_message(avahazard: Callable[..., Result], tmp_path: Path) -> None:
    done = avahazard("db", "backup", str(tmp_path / "none" / "copy.db"))
    assert (done.exit_code, done.stdout) == (1, "")
    assert "No such file or directory" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_error_through_the_installed_command(tmp_path: Path) -> None:
    done = subprocess.run(
        [PROGRAM, "--json", "paths"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("Error: There is no database avahazard.db.")


@pytest.mark.parametrize(("words", "n"), [((), 1), (("--verbose",), 2)])
def test_notes_that_differ_in_numbers_are_one_line_unless_all_are_asked_for(
    avahazard: Callable[..., Result],
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    n: int,
) -> None:
    notes = tuple(Note("few_events", f"P{k}", model="m", n=k) for k in (2, 3))
    monkeypatch.setattr("avahazard.workflow.friction.fit_laws", lambda **_: Fits(Rows(()), notes))
    done = avahazard(*words, "fit")
    assert done.exit_code == 0, done.stderr
    assert done.stderr.count("Note: ") == n


def test_a_table_keeps_its_columns_and_letters_on_a_small_terminal(
    database: str, tmp_path: Path
) -> None:
    """Forty columns wide, with an encoding that has none of the letters of a name."""
    (tmp_path / "paths.csv").write_text("path_id\nŠtít – μ\n", encoding="utf-8")
    import_files(database, [tmp_path / "paths.csv"])
    narrow = os.environ | {"COLUMNS": "40", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}

    def printed(*words: str) -> str:
        done = subprocess.run(
            [PROGRAM, "--db", database, *words], capture_output=True, check=False, env=narrow
        )
        assert (done.returncode, done.stderr) == (0, b"")
        return done.stdout.decode("ascii")

    assert "?t?t ? ?" in printed("paths")
    assert json.loads(printed("--json", "paths"))[0]["path_id"] == "Štít – μ"


def test_an_interruption_of_compiled_code_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        inner = SystemError("returned a result with an exception set")
        inner.__cause__ = KeyboardInterrupt()
        raise SystemError("returned a result with an exception set") from inner

    monkeypatch.setattr("avahazard.workflow.hazard.run_hazard", interrupted)
    done = CliRunner().invoke(app, ["hazard", "base"])
    assert done.exit_code == 130
    assert "Interrupted. The same command goes on" in done.stderr
