"""Scatter that differs by a column."""

from __future__ import annotations

import numpy as np

from avahazard.effects.catalogue import definition
from avahazard.effects.effect import ScatterEffect
from tests.effects.event_table import event_table
from tests.inference.studies import near, observations, posterior

RNG = np.random.default_rng(8)
N = 40
WIND = RNG.standard_normal(N)
SNOW = ["dry"] * 20 + ["wet"] * 12 + ["mixed"] * 5 + ["old"] * 3


def test_levels_and_lines() -> None:
    table = event_table(wind=WIND.tolist(), snow=SNOW)
    for column, names in (("wind", ["slope"]), ("snow", ["mixed", "wet"])):
        entry = definition(f"scatter:{column}")
        assert entry.lacking(table, ()) is None
        made = entry.build(entry.facts(table, ()))
        assert isinstance(made, ScatterEffect)
        assert [p.name for p in made.parameters] == names
        design = made.design(table)
        if column == "wind":
            np.testing.assert_allclose(design[:, 0], (WIND - WIND.mean()) / WIND.std())
        else:
            assert design.tolist() == [[float(s == n) for n in names] for s in SNOW]
        bare = event_table(other=WIND.tolist())
        assert np.array_equal(made.design(bare), np.zeros((N, len(names))))
        assert entry.lacking(bare, ()) == f"there is no column {column}"


def test_few_numbers_tell_no_scatter() -> None:
    few = event_table(wind=WIND[:19].tolist())
    assert definition("scatter:wind").lacking(few, ()) is not None
    assert definition("scatter:wind").lacking(event_table(wind=WIND[:20].tolist()), ()) is None


def test_the_model_scatters_by_it_and_its_mean_stays() -> None:
    given = observations(speeds=False)
    model, base = posterior(given, "scatter:snow_type"), posterior(given)
    logs = {"scatter:snow_type.wet": 0.7, "scatter:snow_type.mixed": -0.4}
    scale = {s.name: s.scale for s in model.layout.slots}
    values = {name: log / scale[name] for name, log in logs.items()}
    location, scatter = model.location_and_scatter(near(model, **values))
    expected_location, expected = base.location_and_scatter(near(base))
    np.testing.assert_array_equal(location, expected_location)
    factor = {"wet": np.exp(0.7), "mixed": np.exp(-0.4)}
    snow = given.columns.texts["snow_type"]
    for i in range(given.n_events):
        np.testing.assert_allclose(scatter[i], factor.get(str(snow[i]), 1.0) * expected[i])
