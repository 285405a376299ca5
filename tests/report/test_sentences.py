"""The verdict in words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.report.model_tables import kinds_table
from avahazard.report.sentences import doubt_text, failure_text, kinds_text, off_text, verdict_text
from avahazard.results.base import Rows
from avahazard.results.calibration import InCommon, Kinds
from avahazard.results.comparison import BeforeAndAfter, ErrorFall, Failure, SpeedMisfit
from avahazard.results.diagnosis import FAR_BEHIND
from tests.results.samples import CALIBRATION, CANDIDATE, COMPARISON, DIAGNOSIS, STANDING

KINDS = Kinds(
    share=0.34,
    shift=-0.27,
    probability={"e1": 0.2, "e2": 0.95, "e3": 0.0001},
    in_common=Rows([InCommon("weather", "storm", -0.31, 0.01)]),
)


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("missing-effect", "lacks an effect: season"),
        ("ambiguous", "cannot determine which"),
        ("unexplained", "no effect of the catalogue"),
        ("adequate", "25 m"),
    ],
)
def test_the_verdict_in_words(verdict: str, words: str) -> None:
    found = replace(DIAGNOSIS, pairs=Rows(), verdict=verdict, missing=("season",))
    sentence = verdict_text(found, "base")
    assert sentence.startswith("base ")
    assert words in sentence


def test_one_with_far_more_evidence_than_the_rest_is_most_likely() -> None:
    keys = ("volume-law", "volume-error")
    law, error = (replace(CANDIDATE, effect=key, evidence_gain=1.0) for key in keys)
    rows = Rows([replace(law, evidence_gain=FAR_BEHIND + 2.0), error])
    found = replace(DIAGNOSIS, pairs=Rows(), verdict="ambiguous", missing=keys, candidates=rows)
    assert verdict_text(found, "base").startswith(
        f"base lacks an effect: most likely {keys[0]}; these data do not rule out {keys[1]}."
    )
    close = replace(found, candidates=Rows([rows[0], replace(rows[1], evidence_gain=2.5)]))
    assert "cannot determine which" in verdict_text(close, "base")


def test_errors_of_the_records_are_told_as_a_multiple_of_those_stated() -> None:
    errors = replace(CANDIDATE, effect="record-error", parameters={"record-error.log_factor": 1.9})
    found = replace(
        DIAGNOSIS,
        pairs=Rows(),
        verdict="missing-effect",
        missing=("record-error",),
        candidates=Rows([errors]),
    )
    assert "The errors would be 6.7 times those stated." in verdict_text(found, "base")


def test_effects_that_are_needed_together_are_named_together() -> None:
    found = replace(DIAGNOSIS, verdict="missing-effect", missing=("season",))
    assert verdict_text(found, "base").startswith(
        "base lacks effects that are needed together: season and snow-type. Together they gain 6.0 "
    )


def test_the_verdict_says_where_the_physics_is() -> None:
    found = replace(
        DIAGNOSIS,
        verdict="missing-effect",
        missing=("forest-drag",),
        where=("It fails beyond chance on P01 (+40 m).", "P01 and P06 have forest."),
    )
    assert verdict_text(found).endswith("(+40 m). P01 and P06 have forest.")


@pytest.mark.parametrize(("share", "words"), [(0.6, "insufficient"), (0.4, "adequate")])
def test_few_data_are_not_called_a_good_model(share: float, words: str) -> None:
    found = replace(DIAGNOSIS, pairs=Rows(), verdict="adequate", missing=(), detectable_share=share)
    assert words in verdict_text(found, "base")
    assert found.cannot_tell == (share > 0.5)


def test_what_is_missing_is_named_however_few_the_data() -> None:
    found = replace(
        DIAGNOSIS, pairs=Rows(), verdict="missing-effect", missing=("season",), detectable_share=0.9
    )
    assert "lacks an effect: season" in verdict_text(found, "base")


def test_a_second_kind_is_told_of_the_model_and_where_it_is_missing() -> None:
    words = (
        "34 % of the avalanches are of a second kind that no column records: their friction is "
        "0.76 times that of the others. 1 of 3 events are more likely of it than not. "
        "Columns that go with it (rank correlation): weather = storm (\u22120.31)."
    )
    assert words in " ".join(kinds_text(KINDS))
    candidate = replace(CANDIDATE, effect="two-kinds", kinds=KINDS)
    found = replace(DIAGNOSIS, candidates=Rows([candidate]), verdict="missing-effect")
    assert words in verdict_text(replace(found, missing=("two-kinds",)))
    assert words not in verdict_text(replace(found, missing=("season",)))
    table = kinds_table(replace(CALIBRATION, kinds=KINDS))
    assert table is not None
    assert table.rows == [["e2", "95 %"], ["e1", "20 %"], ["e3", "under 0.1 %"]]
    assert (kinds_table(CALIBRATION), table.shown) == (None, 0)


def test_an_adequate_model_that_fails_is_said_to_fail() -> None:
    rows = Rows([Failure("path", "P1", 9, -50.0, 1e-4)])
    found = replace(DIAGNOSIS, pairs=Rows(), verdict="adequate")
    said = failure_text(replace(COMPARISON, where_it_fails=rows), {"P1": "North"}, found)
    assert said.startswith("Yet it fails beyond chance by path “North” (9 events, 50 m too low)")


@pytest.mark.parametrize(("low", "said"), [(-1.0, True), (1.0, False)])
def test_a_fall_of_the_error_is_doubted_where_its_interval_holds_none(
    low: float, said: bool
) -> None:
    fall = ErrorFall(5.0, low, 11.0)
    found = BeforeAndAfter(STANDING, STANDING, "path", fall=fall)
    doubt = doubt_text(found, "base")
    assert ("less than “base” (42 m) is not certain" in doubt) == said
    assert doubt_text(replace(found, fall=None), "base") == ""


def test_speeds_that_fail_are_told_beside_stops() -> None:
    stops = Rows([Failure("snow_type", "wet", 9, -50.0, 1e-4)])
    low, high = (
        SpeedMisfit("predicted_speed_m_s", level, 33, bias, 9.7, p)
        for level, bias, p in (("slow", -0.2, 0.5), ("fast", 5.8, 0.002))
    )
    found = replace(COMPARISON, where_it_fails=Rows(), speed_misfit=Rows([low]))
    assert "significantly nowhere" in failure_text(found)
    found = replace(found, speed_misfit=Rows([low, high]))
    assert failure_text(found) == (
        "It fails beyond chance by predicted speed “fast” (33 speeds, 5.8 m/s too fast)."
    )
    both = failure_text(replace(found, where_it_fails=stops))
    assert "snow type “wet” (9 events, 50 m too low)" in both
    assert "“fast” (33 speeds, 5.8 m/s too fast)" in both


@pytest.mark.parametrize(
    ("coordinate", "above", "below"),
    [
        ("elevation", "12 m too high", "12 m too low"),
        ("mixed", "12 m too short", "12 m too far"),
        ("x", "12 m too far", "12 m too short"),
        ("h_over_l", "12.0000 H/L too short", "12.0000 H/L too far"),
    ],
)
def test_which_way_a_bias_goes_hangs_on_what_was_recorded(
    coordinate: str, above: str, below: str
) -> None:
    assert (off_text(12.0, coordinate), off_text(-12.0, coordinate)) == (above, below)
