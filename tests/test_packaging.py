"""The wheel works outside the checkout, with its migrations and its demo data inside."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

import avahazard

ROOT = Path(__file__).parents[1]
PARTS_BESIDE = {"migrations": "avahazard/migrations", "data": "avahazard/data"}
SOURCES = ("avahazard", "migrations", "data", "pyproject.toml", "setup.py", "README.md", "LICENSE")


def run(*command: str | Path, cwd: Path, **environment: str | Path) -> str:
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, **{name: str(value) for name, value in environment.items()}},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a source archive that is built from a copy of the tree."""
    tree = tmp_path_factory.mktemp("tree")
    for name in SOURCES:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tree / name)
    run(sys.executable, "-m", "build", "--no-isolation", ".", cwd=tree)
    (built,) = (tree / "dist").glob("*.whl")
    return built


@pytest.fixture(scope="module")
def scripts(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Commands of a new environment with the wheel; the dependencies are borrowed from ours."""
    home = tmp_path_factory.mktemp("installed")
    venv.create(home, with_pip=False)
    paths = {"base": str(home), "platbase": str(home)}
    packages = Path(sysconfig.get_path("purelib", "venv", paths))
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    binaries = Path(sysconfig.get_path("scripts", "venv", paths))
    run(
        *(sys.executable, "-m", "pip", "--python", binaries / "python"),
        *("install", "--no-deps", "--no-index", wheel),
        cwd=home,
    )
    return binaries


def test_every_file_of_the_packages_is_in_the_wheel(wheel: Path) -> None:
    packed = set(zipfile.ZipFile(wheel).namelist())
    for folder, inside in (("avahazard", "avahazard"), *PARTS_BESIDE.items()):
        files = (path for path in (ROOT / folder).rglob("*") if path.is_file())
        names = {f"{inside}/{path.relative_to(ROOT / folder).as_posix()}" for path in files}
        assert names
        assert not {name for name in names - packed if "__pycache__" not in name}


def test_package_comes_from_the_wheel(scripts: Path, tmp_path: Path) -> None:
    printed = run(
        scripts / "python", "-c", "import avahazard; print(avahazard.__file__)", cwd=tmp_path
    )
    assert Path(printed.strip()).is_relative_to(scripts.parent)


def test_version(scripts: Path, tmp_path: Path) -> None:
    assert avahazard.__version__ in run(scripts / "avahazard", "--version", cwd=tmp_path)


def test_init_runs_the_migrations_in_the_wheel(scripts: Path, tmp_path: Path) -> None:
    run(scripts / "avahazard", "init", cwd=tmp_path)
    assert (tmp_path / "avahazard.db").stat().st_size > 0
    run(scripts / "avahazard", "db", "check", cwd=tmp_path)


@pytest.mark.slow
def test_demo_runs_outside_the_checkout_and_keeps_what_it_compiled(
    scripts: Path, tmp_path: Path
) -> None:
    """Files of the cache are written by the first run alone, here into the user's folder."""
    cache = tmp_path / "cache"
    folder = tmp_path / "empty"
    folder.mkdir()
    document = json.loads(
        run(scripts / "avahazard", "--json", "demo", cwd=folder, NUMBA_CACHE_DIR=cache)
    )
    data = [Path(file) for file in document["files"][-3:]]
    assert all(file.is_file() and file.is_relative_to(scripts.parent) for file in data)
    assert len(document["hazard"]) == 7
    compiled = {file: file.stat().st_mtime_ns for file in cache.rglob("*.nb?")}
    assert compiled
    run(scripts / "avahazard", "demo", cwd=folder, NUMBA_CACHE_DIR=cache)
    assert {file: file.stat().st_mtime_ns for file in cache.rglob("*.nb?")} == compiled
