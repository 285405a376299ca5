"""Finding paths by their names, what is assumed of records, and their fingerprint."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.records.collection import (
    Event,
    Fingerprint,
    Path,
    Profile,
    Records,
    Speed,
    data_fingerprint,
    find_path,
    find_profile,
    only_paths,
    runout_sigma_m,
    speed_sigma_m_s,
)
from avahazard.records.errors import AvahazardError
from tests.workflow.twin import twin_records
from tests.workflow.worlds import bowl


def test_a_path_and_its_profile_are_found() -> None:
    records = bowl()
    assert find_path(records, "B") is records.paths[0]
    assert find_profile(records, records.paths[0]) is records.profiles[0]


def test_what_is_missing_is_said() -> None:
    with pytest.raises(AvahazardError) as unknown:
        find_path(bowl(), "C")
    assert unknown.value.hint == "The paths are: B."
    with pytest.raises(AvahazardError) as empty:
        find_path(Records(), "C")
    assert "avahazard import" in empty.value.hint
    many = Records(tuple(Path(f"p{i}") for i in range(15)))
    with pytest.raises(AvahazardError) as long:
        find_path(many, "C")
    assert long.value.hint.endswith("p11 and 3 more.")
    with pytest.raises(AvahazardError, match="No profile is stored for path p3"):
        find_profile(many, many.paths[3])


def test_paths_that_are_not_there_or_have_no_events() -> None:
    with pytest.raises(AvahazardError, match="no path 'nowhere'"):
        only_paths(twin_records(), ["scey", "nowhere"])
    with pytest.raises(AvahazardError, match="no events on B"):
        only_paths(bowl(), ["B"])
    some = only_paths(twin_records(), ["saugy", "scey"])
    assert {e.path_id for e in some.events} == {p.path_id for p in some.profiles}
    assert [p.path_id for p in some.paths] == ["saugy", "scey"]


@pytest.mark.parametrize(
    ("year", "sigma"), [(None, 10), (1700, 25), (1904, 25), (1940, 17.5), (1975, 10), (2020, 10)]
)
def test_runout_sigma_by_year(year: int | None, sigma: float) -> None:
    assert runout_sigma_m(year) == pytest.approx(sigma)


def test_deposit_is_half_a_block() -> None:
    event = Event("e", deposit_length_m=100, deposit_width_m=20)
    assert event.deposit_m3 is None
    assert replace(event, deposit_thickness_m=3).deposit_m3 == 3000


def test_speed_sigma_is_a_tenth_but_a_metre_per_second() -> None:
    assert [speed_sigma_m_s(v) for v in (0.0, 5.0, 30.0)] == [1, 1, 3]


RECORDS = Records(
    (Path("P"), Path("Q", covariates={"a": 1.0, "b": "x"})),
    (Profile("P", np.arange(5.0), -np.arange(5.0)),),
    (Event("e", "P", runout_x_m=3.0), Event("f", "P", runout_x_m=4.0)),
    (Speed("e", 9.0, 1.0, x_m=1.0),),
)


def test_the_order_does_not_matter() -> None:
    other = replace(
        RECORDS,
        paths=(Path("Q", covariates={"b": "x", "a": 1.0}), Path("P")),
        events=RECORDS.events[::-1],
    )
    assert data_fingerprint(other) == data_fingerprint(RECORDS)


def test_a_zero_has_no_sign() -> None:
    signed, unsigned = (Records(events=(Event("e", "P", runout_x_m=x),)) for x in (-0.0, 0.0))
    assert data_fingerprint(signed) == data_fingerprint(unsigned)


@pytest.mark.parametrize(
    "other",
    [
        replace(RECORDS, events=RECORDS.events[:1]),
        replace(
            RECORDS,
            events=(replace(RECORDS.events[0], runout_x_m=3.0000000000000004), RECORDS.events[1]),
        ),
        replace(RECORDS, profiles=(Profile("P", np.arange(5.0), np.array([0.0, -1, -2, -3, -5])),)),
        replace(RECORDS, paths=(Path("P"), Path("Q", covariates={"a": "1.0", "b": "x"}))),
        replace(RECORDS, speeds=()),
    ],
)
def test_every_value_matters(other: Records) -> None:
    assert data_fingerprint(other) != data_fingerprint(RECORDS)


def test_an_event_without_h_over_l_has_the_fingerprint_that_it_had_before_that_column() -> None:
    events = Records(events=(Event("e", fall_height_m=1.0, runout_length_m=2.0),))
    assert data_fingerprint(events).startswith("748848fe0a60e0c4")
    ratio = Records(events=(Event("e", h_over_l=0.5),))
    assert data_fingerprint(ratio) != data_fingerprint(Records(events=(Event("e", h_over_l=0.4),)))


def test_it_is_that_of_the_lines_sorted_however_they_come() -> None:
    many = Records(
        tuple(Path(f"P{k}", name="a" * (k % 7)) for k in range(50)),
        tuple(Profile(f"P{k}", np.arange(5.0), -np.arange(5.0) * (k % 3)) for k in range(50)),
        tuple(Event(f"e{k % 10}{k}", f"P{k}", runout_x_m=1.0 + k) for k in range(50)),
        tuple(Speed(f"e{k}", 9.0, 1.0, x_m=1.0) for k in range(50)),
    )
    whole = data_fingerprint(many)
    pieces = Fingerprint()
    for k in reversed(range(50)):
        pieces.add(Records(*(kind[k : k + 1] for kind in (many.paths, many.profiles))))
        pieces.add(Records(events=many.events[k : k + 1], speeds=many.speeds[k : k + 1]))
    assert pieces.hexdigest() == whole


def test_it_stays_what_it_was() -> None:
    # Databases hold it.
    assert data_fingerprint(RECORDS) == (
        "992c5a19187af4fc310135187952927d82cd9be96aa4b96c1852017e1fd7859c"
    )


def test_a_piece_has_a_digest_of_its_own() -> None:
    one, same, other = Fingerprint(), Fingerprint(), Fingerprint()
    assert one.add(RECORDS) == same.add(RECORDS) == same.add(RECORDS)
    assert one.add(RECORDS) != other.add(replace(RECORDS, speeds=()))
