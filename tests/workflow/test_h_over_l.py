"""Events of which H/L alone is known, from the file to the scores."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avahazard.inference.model.observations import build_observations
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.records.reading import read_records
from avahazard.store import upkeep
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.compare import compare, predict
from avahazard.workflow.database import import_files
from avahazard.workflow.export import export
from avahazard.workflow.friction import fit_laws, show_frictions
from avahazard.workflow.hazard import run_hazard, volumes, zones
from avahazard.workflow.path import alpha_beta_paths
from avahazard.workflow.requests import (
    CalibrateRequest,
    HazardRequest,
    VolumesRequest,
    ZonesRequest,
)
from tests.conftest import command_line

N = 60
Write = Callable[[str, str], Path]
HEAD = "event_id,h_over_l,volume_m3,release_elevation_m\n"


def drawn() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """H/L = 0.4 (V/1e5)^-0.1 with a scatter of 0.2, volumes and releases."""
    rng = np.random.default_rng(5)
    volume = 1e5 * np.exp(rng.standard_normal(N))
    ratio = 0.4 * (volume / 1e5) ** -0.1 * np.exp(0.2 * rng.standard_normal(N))
    return ratio, volume, rng.uniform(1000.0, 2000.0, N)


def rows(ratio: np.ndarray, volume: np.ndarray, release: np.ndarray) -> str:
    """The text of events.csv."""
    lines = zip(ratio, volume, release, strict=True)
    return HEAD + "".join(f"e{i},{r:.4f},{v:.0f},{z:.0f}\n" for i, (r, v, z) in enumerate(lines))


def refused(call: Callable[[], object], accepted: str) -> None:
    """One row is refused, with what would be accepted."""
    with pytest.raises(RejectedRows) as caught:
        call()
    (problem,) = caught.value.problems
    assert accepted in problem.accepted


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A database with the events and a model `base`; do not write to it."""
    folder = tmp_path_factory.mktemp("h-over-l")
    database, file = str(folder / "ratios.db"), folder / "events.csv"
    upkeep.create(database)
    file.write_text(rows(*drawn()), encoding="utf-8")
    import_files(database, [file])
    calibrate(database, "base", CalibrateRequest(law="power", chains=2, draws=150, seed=1))
    return database


@pytest.fixture
def stored(made: str, tmp_path: Path) -> str:
    """A copy of it."""
    return str(shutil.copy(made, tmp_path / "mine.db"))


def test_scores_are_in_h_over_l(stored: str) -> None:
    found = compare(stored, "base")
    ratio, volume, _ = drawn()
    runout = found.scores.runout
    assert found.coordinate == "h_over_l"
    # A regression of log(H/L) has the same spread.
    line = np.polyfit(np.log(volume), np.log(ratio), 1)
    residual = ratio - np.exp(np.polyval(line, np.log(volume)))
    assert runout.rmse_m == pytest.approx(np.sqrt(np.mean(residual**2)), rel=0.1)
    assert abs(runout.bias_m) < 0.02
    assert 0.8 <= runout.coverage_90 <= 1.0
    # 5 % of H/L are the errors of the records.
    by_source = {part.source: part.rms_m for part in found.budget}
    assert by_source["record"] == pytest.approx(0.05 * np.sqrt(np.mean(ratio**2)), rel=0.02)
    assert by_source["scatter"] == pytest.approx(0.2 * ratio.mean(), rel=0.4)


def test_predictions_are_in_h_over_l(stored: str, write: Write) -> None:
    text = HEAD + "a,,3e3,\nb,0.4,3e6,\n"
    found = predict(stored, "base", write("new.csv", text))
    small, large = found.events
    assert {small.coordinate, large.coordinate} == {"h_over_l"}
    assert small.q50_m == pytest.approx(0.4 * 0.03**-0.1, rel=0.3)
    assert small.q50_m > large.q50_m > 0.1
    assert found.scores is not None
    assert found.scores.coordinate == "h_over_l"
    assert found.scores.runout.n == 1


def test_its_apparent_friction_is_h_over_l(stored: str) -> None:
    ratio, volume, _ = drawn()
    found = show_frictions(stored)
    np.testing.assert_allclose([event.mu for event in found.events], ratio.round(4))
    slope = -np.polyfit(np.log(volume.round()), np.log(ratio.round(4)), 1)[0]
    power = next(entry for entry in fit_laws(stored).rows if entry.law == "power")
    assert power.parameters["beta"].value == pytest.approx(slope, rel=0.2)


@pytest.mark.usefixtures("drawn_little")
def test_people_read_h_over_l(stored: str, write: Write) -> None:
    avahazard = command_line(stored)
    told = avahazard("compare", "base").stdout
    assert "H/L" in told
    assert " m " not in told.replace("m of", "")
    assert "metres" not in told
    document = json.loads(avahazard("--json", "compare", "base").stdout)
    assert document["coordinate"] == "h_over_l"
    new = str(write("new.csv", HEAD + "a,,3e3,\n"))
    stops = avahazard("predict", "base", new).stdout
    assert "H/L" in stops
    assert ", m" not in stops
    errors = avahazard("ladder").stdout
    assert "H/L" in errors
    assert " m " not in errors


def test_what_needs_a_profile_says_so_alike(stored: str, tmp_path: Path) -> None:
    for refuse in (
        lambda: run_hazard(stored, "base", HazardRequest()),
        lambda: zones(stored, "base", ZonesRequest()),
        lambda: export(stored, "base", tmp_path / "bounds.csv"),
        lambda: volumes(stored, VolumesRequest()),
        lambda: alpha_beta_paths(stored),
    ):
        with pytest.raises(AvahazardError, match="so no design runout is possible") as caught:
            refuse()
        assert "avahazard predict" in caught.value.hint


def test_the_release_serves_as_a_column(write: Write) -> None:
    ratio, volume, release = drawn()
    observations = build_observations(read_records([write("e.csv", rows(ratio, volume, release))]))
    np.testing.assert_allclose(observations.columns.release_elevation, release.round())
    assert observations.in_ratio


def test_metres_beside_it_are_refused(stored: str, write: Write) -> None:
    metres = "event_id,fall_height_m,runout_length_m,volume_m3\nx,500,1000,2e4\n"
    refused(lambda: import_files(stored, [write("metres.csv", metres)]), "no score in common")
    both = "event_id,h_over_l,fall_height_m,volume_m3\nx,0.5,,2e4\ny,0.5,400,2e4\n"
    refused(lambda: read_records([write("both.csv", both)]), "no score in common")
    alone = read_records([write("alone.csv", HEAD + "x,0.5,2e4,\n")])
    with_metres = read_records([write("metres.csv", metres)])
    with pytest.raises(AvahazardError, match="no score in common"):
        build_observations(alone, build_observations(with_metres))


def test_an_error_in_metres_is_refused(write: Write) -> None:
    text = "event_id,h_over_l,runout_sigma_m\nx,0.5,20\n"
    refused(lambda: read_records([write("events.csv", text)]), "fall_height_m or runout_length_m")
