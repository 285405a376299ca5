"""Mutants of every form: some of those that `make trust` makes."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.trust.answers import faults_of
from benchmarks.trust.commands import Ran, write_databases
from benchmarks.trust.inputs import mutants_of, read_mutants
from benchmarks.trust.sources import Source, sources

N_MUTANTS = 5
SEED = 1
"""Fixed: what is found by chance belongs into `make trust`, not into a change that it is not of."""
GARBAGE = '{"diagnostics": {"converged": true}, "parameters": {"a": {"mean": 1e20, "sd": 1}}}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("mutants")
    write_databases(made)
    return made


@pytest.fixture(scope="module")
def forms(folder: Path) -> list[Source]:
    return sources(folder)


def test_mutants_are_accepted_or_refused_with_a_message(
    folder: Path, forms: list[Source], tmp_path: Path
) -> None:
    for source in forms:
        (tmp_path / source.file).write_bytes(source.content)
        source.read(str(folder / "records.db"), tmp_path / source.file)
        found = read_mutants(source, N_MUTANTS, SEED, str(folder / "records.db"), tmp_path)
        assert found.faults == [], source.form
        assert found.accepted + found.refused == found.n_mutants > 0


def test_equal_seeds_give_equal_mutants(forms: list[Source]) -> None:
    for source in forms:
        first = list(mutants_of(source, 3, 1))
        assert first == list(mutants_of(source, 3, 1))
        assert first != list(mutants_of(source, 3, 2))


def test_a_reader_that_breaks_is_at_fault(forms: list[Source], tmp_path: Path) -> None:
    def discontinuous(_database: str, _file: Path) -> None:
        raise KeyError("path_id")

    source = Source("x", "x.csv", b"a,b\n1,2\n3,4\n", forms[0].mutate, discontinuous)
    assert len(read_mutants(source, 5, 0, "", tmp_path).faults) == 5


@pytest.mark.parametrize(
    ("ran", "said"),
    [
        (Ran(("--json", "fit"), 0, '{"a": NaN}', "", ""), "no number"),
        (Ran(("--json", "fit"), 1, "", "", "KeyError('x')"), "KeyError"),
        (Ran(("--json", "fit"), 1, "", "", ""), "without a message"),
        (Ran(("--json", "calibrate"), 0, GARBAGE, "", ""), "converged on a"),
    ],
)
def test_what_is_wrong_with_an_answer_is_seen(ran: Ran, said: str) -> None:
    (fault,) = faults_of(ran)
    assert said in fault


def test_a_right_answer_is_not_at_fault() -> None:
    assert list(faults_of(Ran(("--json", "fit"), 0, '{"a": 1.0}', "", ""))) == []
    assert list(faults_of(Ran(("--json", "fit"), 1, "", "Error: no events.", ""))) == []
