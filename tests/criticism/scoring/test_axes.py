"""Levels of events along the axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avahazard.criticism.scoring.axes import event_axes, terciles
from avahazard.inference.model.observations import build_observations
from tests.criticism.studies import slopes, straight


def test_thirds_are_named_by_their_edges() -> None:
    levels = terciles(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, np.nan]), lambda v: f"{v:.1f}")
    assert list(levels) == ["up to 2.7"] * 2 + ["2.7 to 4.3"] * 2 + ["above 4.3"] * 2 + [""]
    assert set(terciles(np.full(4, 7.0), str)) == {""}


def test_every_axis() -> None:
    records = slopes(n_paths=3)
    paths = tuple(
        replace(p, section="open" if k else "channelled", orientation="NE")
        for k, p in enumerate(records.paths)
    )
    events = tuple(
        replace(
            e,
            date=f"19{50 + k:02d}-{1 + k % 3:02d}-28",
            volume_m3=1e4 * (k + 1),
            covariates={"snow_type": "wet" if k % 2 else "dry", "dust": float(k), "flag": k % 2},
        )
        for k, e in enumerate(records.events)
    )
    cover = tuple("open" if x < 1000.0 else "forest" for x in records.profiles[0].x_m)
    profiles = tuple(replace(p, land_cover=cover) for p in records.profiles)
    observations = build_observations(
        replace(records, paths=paths, events=events, profiles=profiles)
    )
    x = np.linspace(600.0, 1500.0, 18)
    axes = event_axes(observations, x)
    assert all(len(levels) == 18 for levels in axes.values())
    assert list(axes["path"][[0, 6, 12]]) == ["P0", "P1", "P2"]
    assert list(axes["volume"][[0, 17]]) == ["up to 67 000 m3", "above 120 000 m3"]
    assert list(axes["month"][:4]) == ["January", "February", "March", "January"]
    assert axes["year"][0] == "up to 1956"
    assert list(axes["section"][[0, 6]]) == ["channelled", "open"]
    assert set(axes["orientation"]) == {"NE"}
    assert list(axes["snow_type"][:2]) == ["dry", "wet"]
    assert list(axes["flag"][:2]) == ["0", "1"]
    assert axes["dust"][17].startswith("above 11.3")
    place = axes["land_cover_at_predicted_stop"]
    np.testing.assert_array_equal(place == "forest", x >= 1000.0)
    # y falls, and so does the slope, all the way.
    assert axes["predicted_stop_elevation_m"][0].startswith("above")
    assert axes["slope_at_predicted_stop"][17].startswith("up to")
    assert axes["place_along_path"][17].startswith("above")


def test_events_without_a_profile() -> None:
    observations = build_observations(straight(9))
    axes = event_axes(observations, np.full(9, np.nan))
    assert set(axes["path"]) == {""}
    assert set(axes["slope_at_predicted_stop"]) == {""}
