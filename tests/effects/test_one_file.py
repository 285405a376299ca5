"""An effect is one file: written into the folder of effects, it is found wherever effects are."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import invalidate_caches
from pathlib import Path

import pytest

import avahazard.effects
from avahazard.criticism.screening.screen import candidate_definitions
from avahazard.effects.catalogue import catalogue
from avahazard.inference.model.observations import build_observations
from avahazard.inference.model.specification import Specification
from avahazard.store import upkeep
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_dataset
from avahazard.workflow.calibrate import add, calibrate
from avahazard.workflow.database import import_files
from avahazard.workflow.diagnose import diagnose_model
from avahazard.workflow.effects import list_effects, show_effect
from avahazard.workflow.hazard import hazard
from avahazard.workflow.report import write_report
from avahazard.workflow.requests import (
    CalibrateRequest,
    DiagnoseRequest,
    HazardRequest,
    ReportRequest,
)
from docs._tools.effects_page import effects_page
from tests.few_draws import few_draws

pytestmark = pytest.mark.usefixtures("drawn_little")

HEAD = """
from dataclasses import replace
import numpy as np
from avahazard.effects.effect import (
    Definition, FrictionEffect, MotionEffect, Parameter, ShiftEffect
)
from avahazard.physics.cells import SPEEDS
"""
FILES = {
    "brush-drag": """
def _resistance(site, resistance, values):
    return replace(resistance, drag=resistance.drag + values[0])

def _build(_facts):
    drag = Parameter("drag", "1/m", 0.0, 0.0, 0.003, 0.0, 0.01)
    return MotionEffect("brush-drag", (drag,), _resistance)

DEFINITION = Definition("brush-drag", "Brush brakes.", "nothing", _build, limits_speed=True)
""",
    "soft-snow": """
def _design(columns):
    values = columns.numbers.get("snow_temperature_c", np.zeros(len(columns)))
    return np.nan_to_num(values / 10.0)[:, None]

def _build(_facts):
    return FrictionEffect("soft-snow", (Parameter("slope", "", 0.0, 0.0, 0.1),), _design)

DEFINITION = Definition("soft-snow", "Warmth softens.", "snow_temperature_c", _build,
                        event_columns=True, column="snow_temperature_c")
""",
    "high-mark": """
def _shift(columns, values):
    return np.full(len(columns), values[0])

def _build(_facts):
    shift = Parameter("shift", "m", 0.0, 0.0, 5.0, 0.0, 10.0)
    return ShiftEffect("high-mark", (shift,), _shift)

DEFINITION = Definition("high-mark", "Marks stand high.", "nothing", _build)
""",
    "slip": """
def _resistance(site, resistance, values):
    return replace(resistance, speed_factor=1.0 - values[0] * SPEEDS / (SPEEDS + 20.0))

def _build(_facts):
    share = Parameter("share", "", 0.0, 0.0, 0.1, 0.0, 0.2)
    return MotionEffect("slip", (share,), _resistance, speed_dependent=True)

DEFINITION = Definition("slip", "Speed slips.", "nothing", _build, order=1)
""",
}
MEANINGS = ("Brush brakes.", "Warmth softens.", "Marks stand high.", "Speed slips.")
ACTS_ON = {"brush-drag": "the motion", "soft-snow": "friction", "high-mark": "the record",
           "slip": "the motion"}  # fmt: skip


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The files stand in the folder of effects, as far as the program can tell; gives a folder."""
    folder = tmp_path_factory.mktemp("effects")
    for key, text in FILES.items():
        (folder / f"{key.replace('-', '_')}.py").write_text(HEAD + text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(avahazard.effects, "__path__", [*avahazard.effects.__path__, str(folder)])
        invalidate_caches()
        catalogue.cache_clear()
        yield tmp_path_factory.mktemp("world")
    for key in FILES:
        sys.modules.pop(f"avahazard.effects.{key.replace('-', '_')}", None)
    catalogue.cache_clear()


@pytest.fixture(scope="module")
def world(written: Path) -> str:
    """A database of a small dataset with a model `base`, and `new` with the four effects."""
    write_dataset(written / "world", *make_dataset(5, 16, 2))
    database = str(written / "world.db")
    upkeep.create(database)
    import_files(database, [written / "world"])
    calibrate(database, "base", CalibrateRequest(law="power", chains=2, draws=50))
    with few_draws():
        add(database, "base", list(FILES), "new")
    return database


def test_the_list_and_the_entry(world: str) -> None:
    rows = {row.key: row for row in list_effects(world)}
    assert next(iter(rows)) == "slip"
    assert list(rows)[27:30] == ["brush-drag", "high-mark", "soft-snow"]
    for key, meaning in zip(FILES, MEANINGS, strict=True):
        assert rows[key].meaning == meaning
        found = show_effect(world, key)
        assert found.acts_on == ACTS_ON[key]
        assert len(found.parameters) == 1


def test_the_diagnosis_tries_it(world: str) -> None:
    records, _ = make_dataset(5, 16, 2)
    observations = build_observations(records)
    keys = [entry.key for entry in candidate_definitions(observations, Specification())]
    assert set(FILES) <= set(keys)
    assert "covariate:snow_temperature_c" not in keys
    found = diagnose_model(world, "base", DiagnoseRequest())
    tried = {row.effect: row.physics for row in found.candidates}
    assert set(MEANINGS) <= set(tried.values())


def test_bounds_and_the_report_know_it(world: str, tmp_path: Path) -> None:
    rows = hazard(world, "new", HazardRequest(volumes=[2e4], draws=100)).rows
    assert "columns of the event" in rows[0].interval
    assert rows[0].runout_x_m.q50 is not None
    write_report(world, "new", tmp_path / "new.html", ReportRequest())
    html = (tmp_path / "new.html").read_text(encoding="utf-8")
    assert all(meaning in html for meaning in MEANINGS)
    assert "has no drag" not in html


@pytest.mark.usefixtures("written")
def test_the_page_of_effects() -> None:
    page = effects_page()
    for key, meaning in zip(FILES, MEANINGS, strict=True):
        assert f"## {key}\n\n{meaning}" in page
