"""Guided inputs: how they are changed, and what an import in earnest must keep to."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avahazard.workflow.import_files import import_files
from benchmarks.trust import guided
from benchmarks.trust.amounts import Amounts
from benchmarks.trust.guided_mutants import varied, words_of
from benchmarks.trust.guided_worker import PACKAGE, READERS, others
from benchmarks.trust.input_sections import guided as section
from benchmarks.trust.jobs import write_databases
from benchmarks.trust.sources import Source, sources


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("guided")
    write_databases(made)
    return made


@pytest.fixture(scope="module")
def forms(folder: Path) -> dict[str, Source]:
    return {source.form: source for source in sources(folder)}


def test_words_are_those_of_the_readers() -> None:
    words = words_of(READERS)
    asked = {"runout_elevation_m", "land_cover", "cp1252", "files", "pressure_kpa_min", ";"}
    assert asked <= set(words)
    assert "friction" not in words_of(["avahazard.records.doubts"])
    assert max(map(len, words)) <= 30


def test_kernels_are_not_instrumented() -> None:
    left_out = set(others())
    assert {"avahazard", "avahazard.physics.point_error", "avahazard.workflow"} <= left_out
    assert not any(name.startswith(READERS) for name in left_out)
    for file in PACKAGE.rglob("*.py"):
        if "\n@kernel" in file.read_text(encoding="utf-8"):
            assert ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts) in left_out


def test_inputs_of_one_seed_are_one_and_what_is_no_file_any_more_is_changed_too(
    forms: dict[str, Source],
) -> None:
    for source in forms.values():
        for data in (source.content, b"\xff\xfe\x00PK", b""):
            made = [varied(source, data, ["volume_m3"], np.random.default_rng(k)) for k in range(9)]
            again = [
                varied(source, data, ["volume_m3"], np.random.default_rng(k)) for k in range(9)
            ]
            assert made == again
            assert data == b"" or any(one != data for one in made), source.form


def test_words_come_into_headings_and_cells(forms: dict[str, Source]) -> None:
    source = forms["events"]
    made = [
        varied(source, source.content, ["QQ"], np.random.default_rng(k)).split(b"\n")
        for k in range(60)
    ]
    assert any(b"QQ" in one[0].split(b",") for one in made)
    assert any(b"QQ" in one[1:][k] for one in made for k in range(len(one) - 1))


def test_right_imports_in_earnest_are_not_at_fault(folder: Path, forms: dict[str, Source]) -> None:
    database = str(folder / "records.db")
    for form in ("paths", "events", "velocities", "workbook"):
        source = forms[form]
        assert source.imported
        assert guided.in_earnest(source, source.content, database, folder) == []
        assert guided.in_earnest(source, source.content[: 2 * 40 + 5], database, folder) == []
    assert not forms["limits"].imported


def test_imports_in_part_and_such_that_change_again_are_seen(
    folder: Path, forms: dict[str, Source], monkeypatch: pytest.MonkeyPatch
) -> None:
    source, database = forms["velocities"], str(folder / "records.db")
    more = folder / "more"
    shutil.copytree(folder / "world", more, dirs_exist_ok=True)
    (more / "paths.csv").write_text("path_id\nX1\n")

    def in_part(at: str, _files: list[Path], **given: Any) -> Any:
        import_files(at, [more / "paths.csv"], **given)
        raise OSError("the disk is gone")

    monkeypatch.setattr(guided, "import_files", in_part)
    found = guided.in_earnest(source, source.content, database, folder)
    assert found == ["refused, and something is stored"]

    calls: list[str] = []

    def other_each_time(at: str, _files: list[Path], **given: Any) -> Any:
        calls.append(at)
        (more / "paths.csv").write_text(f"path_id\nX{len(calls)}\n")
        return import_files(at, [more / "paths.csv"], **given)

    monkeypatch.setattr(guided, "import_files", other_each_time)
    found = guided.in_earnest(source, source.content, database, folder)
    assert found == ["the same again changes paths", "the same again stores something else"]


def test_without_the_fuzzer_it_says_how_to_have_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "atheris", None)
    monkeypatch.setattr(guided.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(SystemExit, match="pip install"):
        guided.guided(Amounts(), folder, print)


def test_some_are_taken_from_all_over_the_row() -> None:
    assert guided.evenly(range(100), 4) == [0, 25, 50, 75]
    assert guided.evenly("ab", 5) == ["a", "b"]
    assert guided.evenly([], 3) == guided.evenly([1], 0) == []


def test_a_form_whose_reader_died_is_shown() -> None:
    found = {
        "amounts": {"mutants": 1, "chains": 0, "seed": 1},
        "rows": [{"form": "dem.tif"}],
        "faults": ["dem.tif: the process died"],
        "import_faults": [],
        "chains": 0, "done": 0, "refused": 0, "chain_faults": [],
    }  # fmt: skip
    assert "- `dem.tif: the process died`" in section(found)
