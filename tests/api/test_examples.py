"""Every public name of the API has a docstring, and its example runs."""

from __future__ import annotations

import doctest
import inspect
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import avahazard as av
from avahazard.api import open_region
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
