"""Every way in which an office may write a table: read right, or refused with a remedy."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from avahazard.records.collection import Path as AvalanchePath
from avahazard.records.collection import Records
from avahazard.records.guess import as_toml, guess_tables
from avahazard.records.intake import Intake
from avahazard.records.mapping import BESIDE
from avahazard.records.reading import read_files
from tests.records.office import COLUMNS, DATES, EVENTS, FORMATS, MARKS, NAMES, Office, write

KNOWN = Records(paths=(AvalanchePath("Pra"), AvalanchePath("Bois")))
RIGHT = [(name, path, day.isoformat(), stop, volume) for name, path, day, stop, volume in EVENTS]
MATRIX = [
    Office(*choice)
    for choice in product((False, True), (False, True), (False, True), NAMES, MARKS, DATES, FORMATS)
]
REMEDIES = (
    "columns.toml",
    "--unknown",
    "the columns of paths (path_id)",
    "cells that are not merged",
    "the path_id of a path",
    "a column event_id",
)


def values(intake: Intake) -> list[tuple[object, ...]]:
    """What was read, in the order of the columns."""
    return [
        (e.event_id, e.path_id, e.date, e.runout_elevation_m, e.volume_m3)
        for e in intake.records.events
    ]


def mapping(office: Office) -> str:
    """The `columns.toml` that a user would write."""
    lines = [f"header = {office.header}"]
    lines += [f"units = {office.header + 1}"] if office.units else []
    lines += ["merged = true"] if office.merged else []
    lines += [f'unknown = ["{office.mark}"]'] if office.mark else []
    own = zip(COLUMNS, NAMES[office.language], strict=True)
    return "\n".join([*lines, "[columns]", *(f'{column} = "{name}"' for column, name in own)])


PAIRS = [
    pytest.param(
        language, format, marks=[pytest.mark.slow] if format != "csv" and language != "en" else []
    )
    for language, format in product(NAMES, FORMATS)
]
"""Workbooks hand their cells on as a text does: in the fast suite one language tries them."""


@pytest.mark.parametrize(("language", "format"), PAIRS)
def test_none_is_read_wrong_in_silence(tmp_path: Path, language: str, format: str) -> None:
    outcomes = {"plain": 0, "refused": 0, "mapped": 0, "mapped refused": 0, "guessed": 0}
    for office in MATRIX:
        if (office.language, office.format) != (language, format):
            continue
        file = tmp_path / f"events.{format}"
        write(file, office)
        (tmp_path / BESIDE).unlink(missing_ok=True)
        _judge(read_files([file], KNOWN), "plain", "refused", office, outcomes)
        (tmp_path / BESIDE).write_text(mapping(office), encoding="utf-8")
        _judge(read_files([file], KNOWN), "mapped", "mapped refused", office, outcomes)
        tables, problems = guess_tables(file)
        assert not problems, office
        (tmp_path / BESIDE).write_text(
            as_toml([(file.name, table) for table in tables]), encoding="utf-8"
        )
        found = read_files([file], KNOWN)
        if not found.problems and values(found) == RIGHT:
            outcomes["guessed"] += 1
    n = len(MATRIX) // len(NAMES) // len(FORMATS)
    # A merged cell cannot be distinguished from an empty one in an .ods and in a text.
    lost = n // 2 if format in ("ods", "csv") else 0
    assert outcomes["mapped"] == n - lost, outcomes
    assert outcomes["guessed"] >= (n - lost) // 4 * 3, outcomes


def _judge(
    found: Intake, right: str, refused: str, office: Office, outcomes: dict[str, int]
) -> None:
    """Count what was read right, or was refused with a remedy in each complaint."""
    if not found.problems:
        assert found.records.events
        read = values(found)
        if office.mark == "-9999" and not office_knows(found):
            # A number may be intended: it is read, with a note.
            assert any("-9999" in str(note) for note in found.notes), office
            return
        assert read == RIGHT, office
        outcomes[right] += 1
        return
    for problem in found.problems:
        assert any(remedy in problem.accepted for remedy in REMEDIES), (office, problem)
    outcomes[refused] += 1


def office_knows(found: Intake) -> bool:
    """Whether no volume is a mark."""
    return all(e.volume_m3 is None or e.volume_m3 > 0.0 for e in found.records.events)
