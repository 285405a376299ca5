"""The user's effect files against what is stored."""

from __future__ import annotations

import datetime as dt
import hashlib
from dataclasses import replace
from pathlib import Path

import pytest

from avahazard.effects.own_file import TEMPLATE
from avahazard.records.errors import AvahazardError
from avahazard.store.models import StoredModel
from avahazard.workflow.stored.own_effects import check_own, read_own, stored_text


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
    return StoredModel("m", {"specification": {"effects": effects}}, None, text, sha, made)


def test_the_order_of_files_does_not_matter(files: list[Path]) -> None:
    text = stored_text(read_own(files), ["two", "one"])
    assert text == stored_text(read_own(files[::-1]), ["one", "season", "two"])
    assert text is not None
    assert text.index('"one"') < text.index('"two"')
    assert stored_text(read_own(files), ["season"]) is None


def test_the_file_of_the_model_and_no_other(files: list[Path]) -> None:
    own = read_own(files)
    stored = model(stored_text(own, ["one"]), "one")
    check_own(stored, own)
    check_own(replace(stored, effect_sha256=None), {})
    with pytest.raises(AvahazardError, match="from a file"):
        check_own(stored, {})
    files[0].write_text(files[0].read_text().replace("0.2", "0.3"), encoding="utf-8")
    with pytest.raises(AvahazardError, match="not the one that m was made with"):
        check_own(stored, read_own(files))


def test_two_files_of_one_key(files: list[Path]) -> None:
    with pytest.raises(AvahazardError, match="Two effect files"):
        read_own([files[0], files[0]])
