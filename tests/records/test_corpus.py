"""Small odd inputs, each with what is read of it or why it is refused.

A case is a folder of `corpus/` with a `case.toml`: `files` to import (those of its folder, else of
the folder `inputs` beside the repository, whose name `inputs` gives), `options` of the import, and
either `refused`, texts that the refusal must hold, or what is read: `paths` and `events` with
some of their values, texts that `notes` and the lines on reading must hold, and `outcomes`, the
columns that are the stop in another form.
"""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import pytest

from avahazard.inference.model.observations import build_observations
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.requests import ImportRequest

CORPUS = Path(__file__).parent / "corpus"
BESIDE = Path(__file__).parents[2].parent / "shared/data/inputs"
INPUTS = Path(os.environ.get("AVAHAZARD_INPUTS", BESIDE))
CASES = sorted(case.parent.name for case in CORPUS.glob("*/case.toml"))


@pytest.mark.parametrize("name", CASES)
def test_case(tmp_path: Path, name: str) -> None:
    case = tomllib.loads((CORPUS / name / "case.toml").read_text(encoding="utf-8"))
    folders = [CORPUS / name]
    if "inputs" in case:
        folders.append(INPUTS / case["inputs"])
        if not INPUTS.is_dir():
            pytest.skip("the inputs that are not part of the repository are not there")
    database = str(tmp_path / "corpus.db")
    init_database(database)
    if "refused" in case:
        with pytest.raises(AvahazardError) as caught:
            _import(database, folders, case)
        error = caught.value
        problems = error.problems if isinstance(error, RejectedRows) else ()
        text = "\n".join([str(error), *map(str, problems)])
        for expected in case["refused"]:
            assert expected in text
        with reading(database) as session:
            assert not load_records(session).paths
        return
    found = _import(database, folders, case)
    said = "\n".join(map(str, [*found.read, *found.notes]))
    for expected in case.get("notes", ()):
        assert expected in said
    if "notes" in case and not case["notes"]:
        assert not found.notes
    with reading(database) as session:
        records = load_records(session)
    if "outcomes" in case:
        assert list(build_observations(records).outcomes) == case["outcomes"]
    for kind, of_kind, key in (
        ("paths", records.paths, "path_id"),
        ("events", records.events, "event_id"),
    ):
        by_name = {getattr(record, key): record for record in of_kind}
        for record_id, values in case.get(kind, {}).items():
            for column, value in values.items():
                record = by_name[record_id]
                held = getattr(record, column, record.covariates.get(column))
                if value == "":
                    assert held is None, column
                else:
                    assert (
                        held == pytest.approx(value) if isinstance(value, float) else held == value
                    )


def _import(database: str, folders: list[Path], case: dict[str, Any]) -> Any:
    def at(name: str) -> Path:
        return next((f / name for f in folders if (f / name).exists()), folders[0] / name)

    options = dict(case.get("options", {}))
    for name in ("dem", "land_cover", "columns"):
        if name in options and at(options[name]).exists():
            options[name] = str(at(options[name]))
    return import_files(database, [at(name) for name in case["files"]], ImportRequest(**options))
