"""The catalogue beside the data."""

from __future__ import annotations

import datetime as dt
import hashlib
from dataclasses import replace
from pathlib import Path

import pytest

from avahazard.effects.catalogue import catalogue
from avahazard.effects.own_file import TEMPLATE
from avahazard.records.errors import AvahazardError
from avahazard.store.results import StoredModel
from avahazard.workflow.effects import (
    NO_DATA,
    list_effects,
    read_own_of,
    show_effect,
    stored_text,
    write_effect_file,
)

KEYS = tuple(catalogue())


def test_every_effect_and_every_column(snow_database: str) -> None:
    rows = {row.key: row for row in list_effects(snow_database)}
    assert list(rows)[: len(KEYS)] == list(KEYS)
    columns = {"snow_type", "snow_temperature_c", "orientation", "northness", "eastness"}
    expected = {f"covariate:{column}" for column in (*columns, "catchment_ha")}
    assert set(rows) - set(KEYS) == expected
    assert rows["snow-type"].lacking is None
    assert all(row.meaning and row.needs for row in rows.values())


def test_without_data(database: str, tmp_path: Path) -> None:
    for place in (database, str(tmp_path / "nothing.db")):
        rows = list_effects(place)
        assert [row.key for row in rows] == list(KEYS)
        assert {row.lacking for row in rows} == {NO_DATA}
        assert show_effect(place, "snow-type").parameters == ()
        assert show_effect(place, "turbulent-drag").acts_on == "the motion"


@pytest.mark.parametrize(
    ("key", "acts_on", "parameters"),
    [
        ("turbulent-drag", "the motion", ["drag"]),
        ("season", "friction", ["slope", "bend"]),
        ("path-effect", "friction", ["tau"]),
        ("epoch-bias", "the record", ["shift", "before"]),
        ("record-error", "the error of the record", ["log_factor"]),
        ("volume-error", "the error of the volume", ["log_factor"]),
        ("volume-scatter", "the scatter of friction", []),
        ("centrifugal", "the motion", []),
    ],
)
def test_one_effect(snow_database: str, key: str, acts_on: str, parameters: list[str]) -> None:
    found = show_effect(snow_database, key)
    assert found.acts_on == acts_on
    assert [p.name for p in found.parameters] == parameters


def test_bounds_are_told(snow_database: str) -> None:
    (drag,) = show_effect(snow_database, "turbulent-drag").parameters
    assert (drag.low, drag.high, drag.neutral) == (0.0, 0.03, 0.0)
    assert show_effect(snow_database, "season").parameters[0].high is None


def test_a_file_that_cannot_be_written_is_not_begun(tmp_path: Path) -> None:
    with pytest.raises(UnicodeEncodeError):
        write_effect_file(tmp_path / "own.py", "\ud800")  # no UTF-8 for it
    assert list(tmp_path.iterdir()) == []


def test_a_template_is_never_written_over(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    assert write_effect_file(file).file == str(file)
    before = file.read_text()
    with pytest.raises(AvahazardError, match="not overwritten"):
        write_effect_file(file)
    assert file.read_text() == before


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    made = []
    for key in ("one", "two"):
        file = tmp_path / f"{key}.py"
        file.write_text(TEMPLATE.replace("my-effect", key), encoding="utf-8")
        made.append(file)
    return made


def model(text: str | None, *effects: str) -> StoredModel:
    sha = None if text is None else hashlib.sha256(text.encode()).hexdigest()
    made = dt.datetime(2020, 1, 1)
    return StoredModel(
        "m", {"specification": {"effects": effects}}, None, text, sha, made, 1, {}, {}
    )


def test_the_order_of_files_does_not_matter(files: list[Path]) -> None:
    text = stored_text(read_own_of(model(None), files), ["two", "one"])
    assert text == stored_text(read_own_of(model(None), files[::-1]), ["one", "season", "two"])
    assert text is not None
    assert text.index('"one"') < text.index('"two"')
    assert stored_text(read_own_of(model(None), files), ["season"]) is None


def test_the_file_of_the_model_and_no_other(files: list[Path]) -> None:
    own = read_own_of(model(None), files)
    stored = model(stored_text(own, ["one"]), "one")
    assert read_own_of(stored, files[:1]).keys() == {"one"}
    assert read_own_of(replace(stored, effect_sha256=None, effect_file=None), []) == {}
    with pytest.raises(AvahazardError, match="from a file"):
        read_own_of(stored, [])
    files[0].write_text(files[0].read_text().replace("0.2", "0.3"), encoding="utf-8")
    with pytest.raises(AvahazardError, match="not the one that m was made with"):
        read_own_of(stored, files)


def test_two_files_of_one_key(files: list[Path]) -> None:
    with pytest.raises(AvahazardError, match="Two effect files"):
        read_own_of(model(None), [files[0], files[0]])
