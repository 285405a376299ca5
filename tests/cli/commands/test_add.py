"""`avahazard add` and `avahazard ladder`."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from avahazard.report.sentences import before_and_after_text
from avahazard.results.comparison import BeforeAndAfter, ErrorFall
from tests.cli.commands.snow import document, refused, run
from tests.results.samples import STANDING

pytestmark = pytest.mark.usefixtures("drawn_little")


def test_the_error_falls_and_the_ladder_shows_it(snow_database: str, tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    document(snow_database, "effect", "new", str(file))
    words = ("add", "base", "my-effect", "--as", "wet", "--effect-file", str(file))
    done = run(snow_database, *words)
    assert done.exit_code == 0, done.stderr
    assert "my-effect.wet" in done.stdout
    assert "falls from" in done.stdout
    rows = document(snow_database, "ladder")
    assert [row["model"] for row in rows] == ["base", "wet"]
    assert set(rows[0]) >= {
        "model", "parent", "added", "rmse_m", "crps_m", "held_out_crps_m", "elpd_loo",
        "elpd_loo_se", "coverage_90", "speed_rmse_m_s",
    }  # fmt: skip
    assert rows[1]["held_out_crps_m"] < rows[0]["held_out_crps_m"]
    table = run(snow_database, "ladder").stdout
    words_of_table = " ".join(table.split())
    assert "my-effect" in table
    # The floor is the model's own: what errors of volumes do to stops goes by its law.
    floors = [
        float(found) for found in re.findall(r"([\d.]+) m to ([\d.]+) m\.", words_of_table)[0]
    ]
    assert 0.0 < floors[0] < floors[1]
    lines = [line for line in table.splitlines() if not line.startswith("  avahazard")]
    assert max(map(len, lines)) <= 80
    again = refused(snow_database, *words)
    assert "There is a model wet already" in again
    said = refused(snow_database, "add", "wet", "season", "--as", "child")
    assert "--effect-file FILE" in said


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (("add", "base", "--as", "new"), 2, "EFFECT"),
        (("add", "base", "season"), 2, "--as"),
        (("add", "base", "warp-drive", "--as", "new"), 1, "There is no effect 'warp-drive'"),
        (("add", "nobody", "season", "--as", "new"), 1, "There is no model nobody"),
    ],
)
def test_bad_input(snow_database: str, words: tuple[str, ...], status: int, message: str) -> None:
    assert message in refused(snow_database, *words, status=status)


def test_ladder_without_a_model(database: str) -> None:
    assert "There is no model yet" in refused(database, "ladder")


def test_the_one_line() -> None:
    floor = replace(STANDING, noise_floor_crps_m=8.0)
    before, after = (replace(floor, held_out_crps_m=crps) for crps in (80.0, 60.0))
    found = BeforeAndAfter(before, after, "path")
    line = before_and_after_text(found)
    assert "falls from 80.0 m to 60.0 m." in line
    assert "Measurement-error floor (CRPS; errors of runout, volume and release): 8.0 m." in line
    sure = before_and_after_text(replace(found, fall=ErrorFall(20.0, 5.0, 35.0)))
    assert "by 5.0 to 35.0 m (90 % interval)" in sure
    rose = before_and_after_text(replace(found, before=replace(STANDING, held_out_crps_m=50.0)))
    assert "(held-out paths) rises from 50.0 m to 60.0 m: do not use the child for runouts." in rose
    stayed = replace(found, before=replace(STANDING, held_out_crps_m=59.99))
    assert "stays at 60.0 m: do not use the child" in before_and_after_text(stayed)
    chance = replace(found, before=replace(after, held_out_crps_m=59.8, held_out_elpd=-900.0))
    chance = replace(chance, after=replace(after, held_out_elpd=-862.0))
    words = before_and_after_text(replace(chance, fall=ErrorFall(-0.2, -1.0, 0.6)))
    assert "rises slightly, from 59.8 m to 60.0 m, but the elpd of held-out records" in words
    assert "rises by 38.0 nats: keep the child." in words
    # Perhaps by chance, yet too much to keep.
    large = replace(chance, before=replace(after, held_out_crps_m=56.0, held_out_elpd=-900.0))
    words = before_and_after_text(replace(large, fall=ErrorFall(-4.0, -9.0, 1.0)))
    assert "rises from 56.0 m to 60.0 m: do not use the child for runouts." in words
    alone = before_and_after_text(replace(found, before=None))
    assert "60.0 m of elevation" in alone
    assert "falls" not in alone
