"""The fingerprint of the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avahazard.records.collection import Records
from avahazard.records.event import Event, Speed
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.path import Path, Profile

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
