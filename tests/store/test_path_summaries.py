"""Paths summed up by the database, against the records summed up one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.records.collection import Records
from avahazard.records.event import Event
from avahazard.records.path import Path, Profile
from avahazard.store.path_summaries import path_summaries
from avahazard.store.save_records import save_records
from avahazard.store.session import reading, writing

X = np.array([0.0, 100.0, 300.0, 600.0, 1000.0])
RECORDS = Records(
    (Path("steep", name="Steep", section="open"), Path("bare"), Path("quiet")),
    (
        Profile("steep", X, np.array([900.0, 700.0, 420.0, 300.5, 310.0])),
        Profile("quiet", X, 500.0 - 0.2 * X),
    ),
    (
        Event("a", path_id="steep", date="1950-02-13", runout_elevation_m=400.0, volume_m3=2e4),
        Event("b", path_id="steep", date="1911", runout_elevation_m=400.0),
        Event("c", path_id="steep", left_profile=True, volume_m3=5e3),
        Event("d", path_id="bare", runout_elevation_m=100.0),
        Event("e", fall_height_m=300.0, runout_length_m=700.0),
    ),
)


def test_each_path_is_summed_up(any_database: str) -> None:
    with writing(any_database) as session:
        save_records(session, RECORDS)
    with reading(any_database) as session:
        steep, bare, quiet = path_summaries(session)
    assert (steep.path_id, steep.name, steep.section) == ("steep", "Steep", "open")
    assert (steep.n_points, steep.top_m, steep.drop_m, steep.length_m) == (5, 900.0, 599.5, 1000.0)
    assert (steep.n_events, steep.n_left_profile) == (3, 1)
    assert (steep.first_year, steep.last_year) == (1911, 1950)
    assert (steep.volume_min_m3, steep.volume_max_m3) == (5e3, 2e4)
    nothing = replace(
        bare, n_points=0, top_m=None, drop_m=None, length_m=None, n_events=1, n_left_profile=0,
        first_year=None, last_year=None, volume_min_m3=None, volume_max_m3=None,
    )  # fmt: skip
    assert bare == nothing
    assert (quiet.n_events, quiet.n_points, quiet.volume_max_m3) == (0, 5, None)
