"""Options are made of requests; those that several commands have are the same in all of them."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from avahazard.cli.options import taking_requests
from avahazard.hazard.volume_source import VolumeSource
from avahazard.request import Request, option
from avahazard.workflow.requests import HazardRequest
from tests.cli.test_help import ALL

OF_THEIR_OWN = {
    "--seed": {"diagnose", "synth"},  # of synthetic datasets
    "--path": {"calibrate", "fit"},  # events, not bounds
    "--volume": {"runout"},  # one, not several
    "--draws": {"calibrate"},  # of each chain
    "--forward": {"simulate"},  # the flow models alone
}


def test_an_option_reads_alike_wherever_it_is() -> None:
    found: dict[str, set[tuple[str | None, object]]] = defaultdict(set)
    for name, command in ALL.items():
        for param in command.params:
            for flag in param.opts:
                if flag.startswith("--") and name not in OF_THEIR_OWN.get(flag, ()):
                    kind = (param.metavar, param.multiple)
                    found[flag].add(kind)
    assert {flag: kinds for flag, kinds in found.items() if len(kinds) > 1} == {}


class Asked(Request):
    """A request with a pair of numbers."""

    pair: tuple[str, ...] = option((), "Two numbers.", parse=tuple)


def called(*words: str) -> tuple[int, str, list[object]]:
    """Exit status, standard error, and what the command was given."""
    seen: list[object] = []

    def command(name: str, *, request: HazardRequest, asked: Asked, far: bool = False) -> None:
        seen.extend((name, request, asked, far))

    app = typer.Typer()
    app.command()(taking_requests(command))
    done = CliRunner().invoke(app, list(words))
    return done.exit_code, done.stderr, seen


def test_what_was_asked_arrives() -> None:
    status, _, seen = called(
        *("m", "-T", "30", "--return-period", "100", "--path", "P01", "--frequency", "gpd"),
        *("--threshold", "5e3", "--volumes", "v.csv", "--pair", "1", "--far"),
    )
    source = VolumeSource(family="gpd", threshold_m3=5e3, table=Path("v.csv"))
    request = HazardRequest(return_periods=[30, 100], paths="P01", source=source)
    assert (status, seen) == (0, ["m", request, Asked(pair=("1",)), True])


def test_what_was_not_asked_is_as_the_request_has_it() -> None:
    assert called("m")[2] == ["m", HazardRequest(), Asked(), False]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--threshold", "5e3"], "--threshold"),
        (["--volumes", "v.csv", "--as-of", "2000"], "--as-of"),
        (["-T", "1"], "return period is 1"),
        (["--draws", "3"], "--draws"),
        (["--frequency", "normal"], "gpd"),
        (["-T", "0,5"], "'0,5' is no number"),
        (["-T", "1e100"], "return period is 1e+100"),
    ],
)
def test_what_cannot_be_is_wrong_usage(words: list[str], named: str) -> None:
    status, said, _ = called("m", *words)
    assert status == 2
    assert named in said


def test_a_choice_that_is_nearly_one_is_answered_with_it() -> None:
    status, said, seen = called("m", "--frequency", "gdp")
    assert (status, seen) == (2, [])
    assert "There is no family of frequencies 'gdp'. Did you mean gpd?" in said
