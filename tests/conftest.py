"""What all tests share: the real data, fresh databases, and the command line."""

from __future__ import annotations

import gc
import json
import os
import shutil
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from sqlalchemy import create_engine, make_url, text
from typer.testing import CliRunner, Result

from avahazard.store import upkeep
from tests.few_draws import few_draws
from tests.once import WORKER, bytecode_once, compile_once, made_once
from tests.order import ordered

ROOT = Path(__file__).resolve().parents[1]
# As the program does (`avahazard.cli.main`); other modules import numpy, this one must not.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_configure(config: pytest.Config) -> None:
    """Share what is compiled among workers."""
    if WORKER:
        compile_once()
        bytecode_once(config)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let workers wait for nothing."""
    if WORKER:
        items[:] = ordered(items)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Let the collector of garbage pass over what stays to the end: modules and tests."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()


def missing(reason: str) -> None:
    """Skip with a reason, but fail where everything has to be there."""
    if os.environ.get("AVAHAZARD_CI"):
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Give the folder with the real data."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        missing(f"the real data are not at {folder}")
    return folder


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a database with tables and no rows; do not write to it."""
    file = tmp_path_factory.mktemp("database") / "empty.db"
    upkeep.create(str(file))
    return file


@pytest.fixture
def database(empty_database: Path, tmp_path: Path) -> str:
    """Give a fresh SQLite database."""
    return str(shutil.copy(empty_database, tmp_path / "avahazard.db"))


@pytest.fixture(params=["sqlite", "postgresql"])
def any_database(request: pytest.FixtureRequest) -> str:
    """Give a fresh database of each kind."""
    name = "database" if request.param == "sqlite" else "postgresql_database"
    return str(request.getfixturevalue(name))


@pytest.fixture
def empty_postgresql() -> Iterator[str]:
    """Give the URL of a PostgreSQL database without tables: a schema of its own."""
    server = os.environ.get("AVAHAZARD_TEST_POSTGRES")
    if not server:
        missing("no PostgreSQL server is named in AVAHAZARD_TEST_POSTGRES")
    assert server is not None
    schema = f"test_{uuid.uuid4().hex}"
    engine = create_engine(server)
    with engine.begin() as connection:
        connection.execute(text(f"CREATE SCHEMA {schema}"))
    url = make_url(server).update_query_dict({"options": f"-csearch_path={schema}"})
    yield url.render_as_string(hide_password=False)
    with engine.begin() as connection:
        connection.execute(text(f"DROP SCHEMA {schema} CASCADE"))
    engine.dispose()


@pytest.fixture
def postgresql_database(empty_postgresql: str) -> str:
    """Give a PostgreSQL database with tables and no rows."""
    upkeep.create(empty_postgresql)
    return empty_postgresql


def command_line(database: str | Path) -> Callable[..., Result]:
    """Return a function that runs the command line on `database`."""
    from avahazard.cli.main import app  # noqa: PLC0415

    runner = CliRunner()

    def run(*words: str) -> Result:
        return runner.invoke(app, ["--db", str(database), *words], prog_name="avahazard")

    return run


@pytest.fixture
def default_engine() -> Iterator[None]:
    """Take back, after the test, which engine and how many workers it chose."""
    from avahazard.engine import close_engine  # noqa: PLC0415
    from avahazard.workers import set_workers  # noqa: PLC0415

    yield
    close_engine()
    set_workers(None)


@pytest.fixture
def drawn_little() -> Iterator[None]:
    """Let comparisons and reports draw little (after what is made once for all tests)."""
    with few_draws():
        yield


@pytest.fixture
def avahazard(database: str) -> Callable[..., Result]:
    """Give a function that runs the command line on `database`."""
    return command_line(database)


@pytest.fixture
def write(tmp_path: Path) -> Callable[[str, str], Path]:
    """Give a function that writes a file into the test's own folder `records`."""
    folder = tmp_path / "records"
    folder.mkdir()

    def write_file(name: str, content: str) -> Path:
        file = folder / name
        file.write_text(content, encoding="utf-8")
        return file

    return write_file


@pytest.fixture(scope="session")
def twin_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with the twin; do not write to it."""
    from avahazard.workflow.database import import_files  # noqa: PLC0415

    def make(folder: Path) -> None:
        upkeep.create(str(folder / "twin.db"))
        import_files(str(folder / "twin.db"), [ROOT / "data"])

    return str(made_once(tmp_path_factory, "twin", make) / "twin.db")


@pytest.fixture
def my_twin(twin_database: str, tmp_path: Path) -> str:
    """Give a database with the twin that may be written to."""
    return str(shutil.copy(twin_database, tmp_path / "twin.db"))


@pytest.fixture(scope="session")
def snow_world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a dataset in which snow type rules, `world`, and `base.db` with a model
    `base` that does not know it; do not write to it."""
    from avahazard.synth.making import make_dataset  # noqa: PLC0415
    from avahazard.synth.writing import write_dataset  # noqa: PLC0415
    from avahazard.workflow.calibrate import calibrate  # noqa: PLC0415
    from avahazard.workflow.database import import_files  # noqa: PLC0415
    from avahazard.workflow.requests import CalibrateRequest  # noqa: PLC0415

    def make(folder: Path) -> None:
        write_dataset(folder / "world", *make_dataset(3, 120, 6, {"snow-type": 1.5}))
        database = str(folder / "base.db")
        upkeep.create(database)
        import_files(database, [folder / "world"])
        calibrate(database, "base", CalibrateRequest(chains=2, draws=300))

    return made_once(tmp_path_factory, "snow", make)


@pytest.fixture
def snow_database(snow_world: Path, tmp_path: Path) -> str:
    """Give a copy of the database of `snow_world`."""
    return str(shutil.copy(snow_world / "base.db", tmp_path / "snow.db"))


@pytest.fixture(scope="session")
def diagnosed_world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with `base.db`, whose model `base` does not know that column_1 matters, and its
    diagnosis: `diagnosis.json`, stored in `diagnosed.db`, `candidates.png` and the shares of
    the work that were reported, `told.json`; do not write to it."""
    from avahazard.workflow.calibrate import calibrate  # noqa: PLC0415
    from avahazard.workflow.database import import_files  # noqa: PLC0415
    from avahazard.workflow.diagnose import diagnose_model  # noqa: PLC0415
    from avahazard.workflow.requests import CalibrateRequest, DiagnoseRequest  # noqa: PLC0415
    from tests.criticism.lengths import as_csv, lengths  # noqa: PLC0415

    def make(folder: Path) -> None:
        base, diagnosed = str(folder / "base.db"), str(folder / "diagnosed.db")
        (folder / "events.csv").write_text(as_csv(lengths(90, 0.12)), encoding="utf-8")
        upkeep.create(base)
        import_files(base, [folder / "events.csv"])
        calibrate(base, "base", CalibrateRequest(law="power", chains=2, draws=100))
        shutil.copy(base, diagnosed)
        told: list[float] = []
        found = diagnose_model(
            diagnosed,
            "base",
            DiagnoseRequest(plot=folder / "candidates.png"),
            lambda _what, share: told.append(share),
        )
        (folder / "diagnosis.json").write_text(json.dumps(found.to_dict()), encoding="utf-8")
        (folder / "told.json").write_text(json.dumps(told), encoding="utf-8")

    return made_once(tmp_path_factory, "diagnosed", make)


@pytest.fixture(scope="session")
def report_database(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give a database with three paths of the twin under hostile names, and the model `m` with all
    that a report shows; do not write to it."""
    from tests.report.html.world import make_report_database  # noqa: PLC0415

    return str(made_once(tmp_path_factory, "report", make_report_database) / "report.db")
