"""Models with priors as numbers."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from avahazard.inference.model.specification import GivenPrior
from avahazard.notes import Note
from avahazard.records.errors import AvahazardError
from avahazard.results.calibration import Calibration
from avahazard.store import upkeep
from avahazard.store.records import load_records
from avahazard.store.results import load_model
from avahazard.store.session import reading
from avahazard.workflow.calibrate import add, calibrate, rerun, show_model, show_provenance
from avahazard.workflow.database import import_files
from avahazard.workflow.requests import CalibrateRequest
from avahazard.workflow.stored import load_stored, notes_of
from tests.workflow.twin import DATA

QUICK = {"chains": 2, "draws": 150, "paths": ["scey"]}


def told_of(found: Calibration, key: str) -> list[Note]:
    return [note for note in found.notes if note.key == key]


def given_in(found: Calibration) -> set[str]:
    """The parameters whose prior was given as numbers."""
    return {note.values["parameter"] for note in told_of(found, "prior_given")}


@pytest.fixture
def database(twin_database: str, tmp_path: Path) -> str:
    return str(shutil.copy(twin_database, tmp_path / "copy.db"))


def test_two_normals_make_the_posterior(database: str) -> None:
    """Precisions of the numbers and of the records add up, the weak prior's counted once."""
    calibrate(database, "alone", CalibrateRequest(chains=2, draws=600, paths=["scey"]))
    alone = load_stored(database, "alone")[0].draws[:, :2]
    mean, sd = float(np.exp(alone[:, 0].mean()) * 1.15), 0.03
    found = calibrate(
        database,
        "told",
        CalibrateRequest(prior={"a": (mean, sd)}, chains=2, draws=600, paths=["scey"]),
    )
    told = load_stored(database, "told")[0].draws[:, :2]
    variance = np.log1p((sd / mean) ** 2)
    centre = np.array([np.log(mean) - 0.5 * variance, 0.0])
    weak, new = np.diag([0.5**-2, 0.0]), np.diag([1.0 / variance, 0.0])
    both = np.linalg.inv(np.cov(alone, rowvar=False))
    covariance = np.linalg.inv(both - weak + new)
    expected = covariance @ (both @ alone.mean(axis=0) - weak @ [np.log(0.5), 0.0] + new @ centre)
    width = np.sqrt(np.diag(covariance))
    assert np.abs((told.mean(axis=0) - expected) / width).max() < 0.4
    np.testing.assert_allclose(told.std(axis=0), width, rtol=0.25)
    assert found.parameters["a"].mean > np.exp(alone[:, 0].mean()) * 1.02
    (note,) = told_of(found, "prior_given")
    assert (note.values["parameter"], note.values["mean"], note.values["sd"]) == ("a", mean, sd)


def test_it_stays_with_the_model(database: str) -> None:
    numbers = {"a": (0.5, 0.02), "sigma": (0.2, 0.01)}
    calibrate(database, "told", CalibrateRequest(prior=numbers, chains=2, draws=60, paths=["scey"]))
    stored, _ = load_stored(database, "told")
    # The report shows the notes of the calibration.
    note = "the prior of a in told is 0.5 ± 0.02, as given."
    assert (
        stored.calibration.notes.count(note) == show_model(database, "told").notes.count(note) == 1
    )
    assert {g.name: (g.mean, g.sd) for g in stored.specification.given} == numbers
    assert rerun(database, "told").identical
    specification = show_provenance(database, "told").specification
    assert specification["prior"]["source"] == "given:a"
    assert "given" in specification
    with reading(database) as session:
        notes = notes_of(load_model(session, "told"), load_records(session))
    assert note in notes
    # So narrow, the prior dominates; the note of it knows the numbers, not the weak prior.
    assert any("log sigma is weakly identified" in note for note in notes)


@pytest.mark.usefixtures("drawn_little")
def test_a_child_of_another_law_keeps_the_prior_of_the_rest_and_has_its_own_prior(
    database: str,
) -> None:
    numbers = {"a": (0.5, 0.02), "sigma": (0.2, 0.05)}
    found = calibrate(
        database, "told", CalibrateRequest(prior=numbers, chains=2, draws=60, paths=["scey"])
    )
    assert given_in(found) == {"a", "sigma"}
    child = add(database, "told", ["volume-law"], "child")
    assert load_stored(database, "child")[0].specification.prior is None
    assert given_in(child) == {"sigma"}
    # A child has what its parent was given and is its own still.
    layout = load_stored(database, "child")[0].posterior.layout
    sigma = layout.slots[layout.scatter]
    assert (sigma.mean, sigma.sd) == GivenPrior("sigma", 0.2, 0.05).in_log
    assert [slot.sd for slot in layout.slots[:2]] == list(layout.law.prior_sd[:2])


def test_a_parameter_of_an_effect(database: str) -> None:
    found = calibrate(
        database,
        "drag",
        CalibrateRequest(
            with_=["turbulent-drag"], prior={"turbulent-drag.drag": (0.002, 0.0001)}, **QUICK
        ),
    )
    drag = found.parameters["turbulent-drag.drag"]
    assert drag.mean == pytest.approx(0.002, abs=0.0002)
    assert drag.sd == pytest.approx(0.0001, rel=0.4)


def test_what_is_sampled_by_its_log_and_a_slope_of_scatter(database: str) -> None:
    numbers = {"wrong_share": (0.1, 0.005), "sigma_n": (1e-6, 2e-8)}
    found = calibrate(
        database,
        "told",
        CalibrateRequest(tails="student", scatter="volume", prior=numbers, **QUICK),
    )
    # So narrow, the priors speak.
    for name, (mean, sd) in numbers.items():
        assert found.parameters[name].mean == pytest.approx(mean, abs=1.5 * sd), name
        assert found.parameters[name].sd == pytest.approx(sd, rel=0.4), name
    assert given_in(found) == set(numbers)
    assert "the prior of wrong_share in told is 0.1 ± 0.005, as given." in found.notes
    assert {"log wrong share", "sigma_n"} <= {
        note.values["parameter"] for note in told_of(found, "prior_dominated")
    }


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"prior": {"b": (1.0, 0.1)}}, "no prior of 'b'"),
        ({"prior": {"b": (1.0, 0.1)}, "law": "rational"}, "no prior of 'b'"),
        ({"prior": {"turbulent-drag.drag": (0.002, 0.001)}}, "no prior of 'turbulent-drag.drag'"),
        ({"prior": {"a": (-0.5, 0.1)}}, "a is positive"),
        ({"prior": {"sigma": (-0.5, 0.1)}}, "sigma is positive"),
        ({"prior": {"sigma": (50.0, 0.1)}}, "sigma=50,0.1 is out of range"),
        ({"prior": {"path-effect.tau": (0.1, 0.05)}}, "no prior of 'path-effect.tau'"),
        ({"prior": {"track_sigma": (0.05, 0.02)}}, "no prior of 'track_sigma'"),
        ({"prior": {"wrong_share": (0.5, 0.1)}, "tails": "student"}, "wrong_share=0.5,0.1 is out"),
        ({"prior": {"sigma_n": (1e-6, 1.0)}, "scatter": "volume"}, "times that of the weak"),
        ({"prior": {"n": (2.0, 1e-6)}}, r"\(n=2 1/m3\) gives friction"),
        ({"prior": {"n": (2e-6, 1.0)}}, "times that of the weak prior"),
        ({"prior": {"a": (0.5,)}}, "1 of two numbers"),
        ({"prior": {"a": (0.5, 0.1)}, "method": "gibbs"}, "does not work with priors as numbers"),
        ({"prior": {"a": (0.5, 0.1)}, "prior_from": "fit:nants"}, "prior from fit:nants"),
    ],
)
def test_what_is_no_prior_of_this_model(database: str, asked, message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        calibrate(database, "x", CalibrateRequest(**QUICK, **asked))


FEW = {"chains": 2, "draws": 150}


@pytest.fixture(scope="module")
def with_source(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Give the twin with a model `alone` of one path."""
    file = str(tmp_path_factory.mktemp("prior") / "twin.db")
    upkeep.create(file)
    import_files(file, [DATA])
    calibrate(file, "alone", CalibrateRequest(paths=["scey"], **FEW))
    return file


@pytest.fixture
def sourced(with_source: str, tmp_path: Path) -> str:
    return str(shutil.copy(with_source, tmp_path / "copy.db"))


def law_of(database: str, name: str) -> np.ndarray:
    return load_stored(database, name)[0].draws[:, :2]


def test_the_same_events_never_count_twice(sourced: str) -> None:
    with pytest.raises(
        AvahazardError, match=r"15 of 15 events are in the prior too, .* count twice"
    ):
        calibrate(
            sourced, "x", CalibrateRequest(paths=["scey"], prior_from="fit:nants, scey", **FEW)
        )


def test_a_fit_to_other_paths(sourced: str) -> None:
    asked = CalibrateRequest(paths=["scey"], prior_from="fit:saint-clement", **FEW)
    calibrate(sourced, "fitted", asked)
    prior = load_stored(sourced, "fitted")[0].specification.prior
    assert prior is not None
    assert prior.sd[0] < 0.1
    assert law_of(sourced, "fitted")[:, 1].std() < 0.5 * law_of(sourced, "alone")[:, 1].std()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"prior_from": "fit:nants", "with_": ["turbulent-drag"]}, "A fit knows no turbulent-drag"),
        ({"prior_from": "fit:nants", "method": "gibbs"}, "does not work with a prior"),
        ({"prior_from": "nothing"}, "names no path"),
        ({"prior_from": "fit:nowhere"}, "'nowhere'"),
        ({"prior_from": "fit:"}, "names no path"),
    ],
)
def test_what_cannot_be_the_source_of_a_prior(sourced: str, asked, message: str) -> None:
    with pytest.raises(AvahazardError, match=message):
        calibrate(sourced, "x", CalibrateRequest(paths=["scey"], **FEW, **asked))
