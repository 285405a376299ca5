"""Every public name of the API has a docstring, and its example runs."""

from __future__ import annotations

import doctest
import gc
import inspect
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import avahazard as av
from avahazard.api import open_region
from avahazard.records.errors import AvahazardError, RejectedRows
from avahazard.synth.making import make_dataset
from avahazard.synth.writing import write_dataset

pytestmark = pytest.mark.usefixtures("drawn_little")

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
EXAMPLES = [
    found
    for thing in (av, open_region, av.Region, av.Model)
    for found in doctest.DocTestFinder(recurse=thing is not av).find(thing, globs={})
    if found.examples
]


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Give what the examples may name: a small dataset in `folder`, its region, and a model."""
    top = tmp_path_factory.mktemp("api")
    write_dataset(top / "world", *make_dataset(1, 60, 3, {}))
    region = av.Region.from_files(top / "world", database=top / "region.db")
    base = region.calibrate("base", chains=2, draws=150)
    return {
        "av": av,
        "folder": top / "world",
        "database": region.database,
        "region": region,
        "base": base,
    }


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_the_example_runs(example: doctest.DocTest, names: dict[str, Any]) -> None:
    example.globs = dict(names)
    said: list[str] = []
    failed, tried = doctest.DocTestRunner(optionflags=FLAGS).run(example, out=said.append)
    assert tried > 0
    assert failed == 0, "".join(said)


@pytest.mark.parametrize("thing", [av.Region, av.Model, open_region])
def test_every_public_name_has_an_example(thing: Any) -> None:
    members = vars(thing).items() if inspect.isclass(thing) else [(thing.__name__, thing)]
    lacking = [
        name
        for name, member in members
        if not name.startswith("_")
        and (callable(member) or isinstance(member, property | classmethod))
        and ">>>" not in (inspect.getdoc(member) or "")
    ]
    assert lacking == []


def test_importing_loads_nothing_heavy() -> None:
    code = "import sys, avahazard; print(sorted(m for m in sys.modules if m.startswith('numpy')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_temporary_region_goes_with_its_object(names: dict[str, Any]) -> None:
    region = av.Region.from_files(names["folder"])
    file = Path(region.database)
    assert file.exists()
    del region
    assert not file.exists()


def test_a_database_that_is_there_is_not_overwritten(names: dict[str, Any]) -> None:
    with pytest.raises(av.AvahazardError, match="is there already"):
        av.Region.from_files(names["folder"], database=names["database"])


def test_a_temporary_region_stays_as_long_as_its_models(names: dict[str, Any]) -> None:
    model = av.Region.from_files(names["folder"]).calibrate("base", chains=2, draws=50)
    gc.collect()
    assert model.result.n_events == 60
    file = Path(model.database)
    del model
    gc.collect()
    assert not file.exists()


def test_a_region_stays_where_it_is_when_the_notebook_goes_elsewhere(
    names: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = Path(names["database"])
    monkeypatch.chdir(file.parent)
    region = av.open(file.name)
    monkeypatch.chdir(tmp_path)
    assert len(region.paths()) == 3
    monkeypatch.setenv("HOME", str(file.parent))
    assert av.open(f"~/{file.name}") == region


def test_a_refused_import_leaves_no_database_and_says_which_rows(tmp_path: Path) -> None:
    rows, database = tmp_path / "events.csv", tmp_path / "new.db"
    rows.write_text("event_id,runout_length_m,fall_height_m\ne1,1000,much\n", encoding="utf-8")
    with pytest.raises(RejectedRows) as caught:
        av.Region.from_files(rows, database=database)
    assert "line 2, fall_height_m: 'much'; right is" in str(caught.value)
    assert not database.exists()


def test_options_of_a_method_are_those_of_its_signature(names: dict[str, Any]) -> None:
    base = names["base"]
    assert base.runout(path_id="P01", mu=np.float32(0.5)).mu == 0.5
    assert "model" not in inspect.signature(base.runout).parameters
    for call, words in (
        (lambda: base.runout("P01", mu=0.5, model="other"), "no option 'model'"),
        (lambda: base.hazard(return_period=100), "Did you mean return_periods"),
        (lambda: base.hazard(draws="many"), "It must be a whole number from 100"),
        (lambda: names["region"].hazard([]), "No model is named"),
        (lambda: base.hazard(seed=1.5), "It must be a whole number"),
        (lambda: names["region"].runout("P01", np.array([0.5, 0.6])), "It must be a number over 0"),
        (lambda: base.predict(names["region"].events().to_frame()), "frame.to_csv"),
    ):
        with pytest.raises(AvahazardError, match=words):
            call()


def test_several_models_are_objects_or_names(names: dict[str, Any]) -> None:
    region, base = names["region"], names["base"]
    one, other = (region.hazard([m], return_periods=100, paths="P01") for m in (base, "base"))
    assert one == other
    assert region.hazard("base", return_periods=100, paths="P01") == one


def test_columns_of_ones_own_have_their_names_in_frames(names: dict[str, Any]) -> None:
    frame = names["region"].events().to_frame()
    assert "snow_type" in frame.columns
    assert not any(name.startswith("covariates") for name in frame.columns)


@pytest.mark.parametrize(("version", "groups"), [("0.23.4", False), ("1.0.0", True)])
def test_draws_go_to_any_arviz(
    names: dict[str, Any], monkeypatch: pytest.MonkeyPatch, version: str, groups: bool
) -> None:
    arviz = SimpleNamespace(__version__=version, from_dict=lambda given: given)
    monkeypatch.setitem(sys.modules, "arviz", arviz)
    given = names["base"].to_arviz()
    assert ("sigma" in given, "posterior" in given) == (not groups, groups)
