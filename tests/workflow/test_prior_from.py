"""A law whose prior is what other paths say of it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store import upkeep
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.import_files import import_files
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.rerun import rerun
from avahazard.workflow.stored.model import load_stored
from tests.workflow.twin import DATA

QUICK = {"chains": 2, "draws": 150}


@pytest.fixture(scope="module")
def with_source(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give the twin with a model `elsewhere` of one path and `alone` of another."""
    file = str(tmp_path_factory.mktemp("prior") / "twin.db")
    upkeep.create(file)
    import_files(file, [DATA])
    calibrate(file, "elsewhere", CalibrateRequest(paths=["saugy"], **QUICK))
    calibrate(file, "alone", CalibrateRequest(paths=["scey"], **QUICK))
    return file


@pytest.fixture
def database(with_source: str, tmp_path: Path) -> str:
    return str(shutil.copy(with_source, tmp_path / "copy.db"))


def law_of(database: str, name: str) -> np.ndarray:
    return load_stored(database, name)[0].draws[:, :2]


def test_what_two_paths_say_adds_up(database: str) -> None:
    """With normals the posterior's precision is the sum of both, less the weak prior's once."""
    found = calibrate(
        database,
        "both",
        CalibrateRequest(paths=["scey"], prior_from="elsewhere", chains=2, draws=600),
    )
    assert found.prior is not None
    assert found.prior.source == "elsewhere"
    source, alone, both = (law_of(database, name) for name in ("elsewhere", "alone", "both"))
    told = [found.prior.coordinates[key] for key in ("log a", "n in 1e-6/m3")]
    np.testing.assert_allclose([c.mean for c in told], source.mean(axis=0))
    np.testing.assert_allclose([c.sd for c in told], source.std(axis=0, ddof=1))
    precisions = [np.linalg.inv(np.cov(u, rowvar=False)) for u in (source, alone)]
    weak = np.diag([0.5**-2, 10.0**-2])
    covariance = np.linalg.inv(precisions[0] + precisions[1] - weak)
    mean = covariance @ (
        sum(p @ u.mean(axis=0) for p, u in zip(precisions, (source, alone), strict=True))
        - weak @ [np.log(0.5), 0.0]
    )
    sd = np.sqrt(np.diag(covariance))
    assert np.abs(both.mean(axis=0) - mean) == pytest.approx(0.0, abs=0.4 * sd.max())
    np.testing.assert_allclose(both.std(axis=0), sd, rtol=0.25)
    again = load_stored(database, "both")[0].specification.prior
    assert again is not None
    assert again.source == "elsewhere"
    assert rerun(database, "both").identical


def test_the_same_events_never_count_twice(database: str) -> None:
    with pytest.raises(AvahazardError, match=r"19 of 19 events already speak through elsewhere"):
        calibrate(database, "x", CalibrateRequest(paths=["saugy"], prior_from="elsewhere", **QUICK))
    with pytest.raises(AvahazardError, match="would count twice"):
        calibrate(
            database, "x", CalibrateRequest(paths=["scey"], prior_from="fit:nants, scey", **QUICK)
        )
    # Through a model whose own prior had them.
    calibrate(database, "second", CalibrateRequest(paths=["scey"], prior_from="elsewhere", **QUICK))
    with pytest.raises(AvahazardError, match="through second"):
        calibrate(database, "x", CalibrateRequest(paths=["saugy"], prior_from="second", **QUICK))


def test_a_fit_to_other_paths(database: str) -> None:
    found = calibrate(
        database,
        "fitted",
        CalibrateRequest(paths=["scey"], prior_from="fit:saint-clement", **QUICK),
    )
    assert found.prior is not None
    assert found.prior.coordinates["log a"].sd < 0.1
    assert law_of(database, "fitted")[:, 1].std() < 0.5 * law_of(database, "alone")[:, 1].std()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"prior_from": "elsewhere", "law": "power"}, "another law"),
        ({"prior_from": "elsewhere", "distribution": "normal"}, "another distribution"),
        ({"prior_from": "elsewhere", "without": ["centrifugal"]}, "another curvature"),
        (
            {"prior_from": "elsewhere", "with_": ["turbulent-drag"]},
            "another set of effects on the motion",
        ),
        ({"prior_from": "fit:nants", "with_": ["turbulent-drag"]}, "A fit knows no turbulent-drag"),
        ({"prior_from": "elsewhere", "method": "gibbs"}, "does not work with a prior"),
        ({"prior_from": "nothing"}, "model nothing"),
        ({"prior_from": "fit:nowhere"}, "'nowhere'"),
        ({"prior_from": "fit:"}, "names no path"),
    ],
)
def test_what_is_no_prior_of_this_model(database: str, asked, message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        calibrate(database, "x", CalibrateRequest(paths=["scey"], **QUICK, **asked))
