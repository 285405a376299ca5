"""Options that several commands have are the same in all of them."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import pytest
import typer

from avahazard.cli.options import FamilyName, volume_source
from tests.cli.test_help import ALL

OF_THEIR_OWN = {
    "--seed": {"diagnose", "synth"},  # of made worlds
    "--path": {"calibrate", "fit"},  # events, not bounds
    "--volume": {"runout"},  # one, not several
    "--draws": {"calibrate"},  # of each chain
}


def test_an_option_reads_alike_wherever_it_is() -> None:
    found: dict[str, set[tuple[str | None, object]]] = defaultdict(set)
    for name, command in ALL.items():
        for option in command.params:
            for flag in option.opts:
                if flag.startswith("--") and name not in OF_THEIR_OWN.get(flag, ()):
                    kind = (option.metavar, option.multiple)
                    found[flag].add(kind)
    assert {flag: kinds for flag, kinds in found.items() if len(kinds) > 1} == {}


@pytest.mark.parametrize(
    ("threshold", "table", "snowfall", "named"),
    [
        (5e3, None, None, "--threshold"),
        (None, Path("v.csv"), Path("s.csv"), "--snowfall"),
    ],
)
def test_contradictions_are_wrong_usage(
    threshold: float | None, table: Path | None, snowfall: Path | None, named: str
) -> None:
    with pytest.raises(typer.BadParameter, match=named):
        volume_source(FamilyName.gev, threshold, table, snowfall, 0.5)


def test_what_was_asked_arrives() -> None:
    source = volume_source(FamilyName.gpd, 5e3, None, None, 0.4)
    assert (source.family, source.threshold_m3, source.density_ratio) == ("gpd", 5e3, 0.4)
