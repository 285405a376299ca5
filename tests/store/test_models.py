"""Models in every kind of database."""

from __future__ import annotations

import hashlib

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.models import list_models, load_model, save_model
from avahazard.store.session import reading, writing

SPECIFICATION = {"law": "exponential", "effects": ["turbulent-drag"], "depth": {"x": 1.5}}


def test_models_come_back_oldest_first(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "b", SPECIFICATION)
        save_model(session, "a", {}, parent="b", effect_file="x = 1\n")
    with reading(any_database) as session:
        first, second = list_models(session)
        assert load_model(session, "b") == first
    assert (first.name, first.specification, first.parent) == ("b", SPECIFICATION, None)
    assert (second.name, second.parent, second.effect_file) == ("a", "b", "x = 1\n")
    assert second.effect_sha256 == hashlib.sha256(b"x = 1\n").hexdigest()
    assert second.created >= first.created


def test_a_name_is_taken_once(any_database: str) -> None:
    with writing(any_database) as session:
        save_model(session, "a", {})
    with pytest.raises(AvahazardError, match="a model a already"), writing(any_database) as session:
        save_model(session, "a", SPECIFICATION)
    with reading(any_database) as session:
        assert load_model(session, "a").specification == {}


@pytest.mark.parametrize("name", ["", "  ", "x" * 201])
def test_a_name_is_short_and_not_empty(database: str, name: str) -> None:
    with pytest.raises(AvahazardError, match="1 to 200"), writing(database) as session:
        save_model(session, name, {})


def test_a_missing_model_or_parent_is_said(database: str) -> None:
    with writing(database) as session:
        with pytest.raises(AvahazardError) as caught:
            load_model(session, "a")
        assert "avahazard calibrate a" in caught.value.hint
        save_model(session, "b", {})
        with pytest.raises(AvahazardError, match="no model c") as caught:
            save_model(session, "d", {}, parent="c")
        assert "Stored are: b" in caught.value.hint
