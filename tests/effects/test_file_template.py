"""The template of an effect file is itself an effect file."""

from __future__ import annotations

import numpy as np

from avahazard.effects.effect import FrictionEffect, MotionEffect
from avahazard.effects.file_template import TEMPLATE
from avahazard.effects.from_file import definition_from
from tests.effects.event_table import event_table


def test_it_runs_as_it_is() -> None:
    found = definition_from(TEMPLATE, "template.py")
    assert found.key == "my-effect"
    columns = event_table(snow_type=["wet", "dry", "wet", "dry", "mixed"])
    assert found.lacking(columns, ()) is None
    effect = found.build({})
    assert isinstance(effect, FrictionEffect)
    np.testing.assert_array_equal(effect.design(columns)[:, 0], [1.0, 0.0, 1.0, 0.0, 0.0])


def test_it_is_short_enough_to_be_read() -> None:
    lines = [line.strip() for line in TEMPLATE.splitlines()]
    code = [line for line in lines if line and not line.startswith(("#", '"""'))]
    assert len(code) <= 25
    assert max(map(len, TEMPLATE.splitlines())) <= 100


def test_its_second_example_runs_too() -> None:
    start = TEMPLATE.index("# PARAMETERS = [")
    example = "\n".join(line.removeprefix("# ") for line in TEMPLATE[start:].splitlines())
    head = TEMPLATE[: TEMPLATE.index("# Exactly one function")]
    found = definition_from(head + example, "template.py")
    assert isinstance(found.build({}), MotionEffect)
