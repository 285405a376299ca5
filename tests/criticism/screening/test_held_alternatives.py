from __future__ import annotations

import numpy as np

from avahazard.criticism.screening.alternatives import Alternative, AtHand
from avahazard.criticism.screening.held_alternatives import HeldAlternatives
from avahazard.criticism.screening.model_design import base_design
from avahazard.criticism.screening.tables import Tables, make_tables
from avahazard.inference.likelihood.predicted import predict_records
from tests.inference import studies


def alternative(key: str, tables: Tables) -> Alternative:
    model = studies.posterior(studies.observations())
    design = base_design(model, studies.near(model), model.plan, np.empty(0))
    return Alternative(key, tables, design, 0.0)


def tables() -> Tables:
    observations = studies.observations()
    predicted = predict_records(observations, (), {})
    return make_tables(observations, predicted, observations.limit, 0.0)


def looks(most_bytes: int) -> tuple[list[list[str]], list[str], bool]:
    """Keys of two looks, the keys whose tables were made, and whether all were held."""
    base, made = tables(), []

    def spell(key: str) -> list[Alternative]:
        made.append(key)
        return [alternative(key, tables())]

    spelled = [
        AtHand([alternative("at hand", base)]),
        lambda: spell("first"),
        lambda: spell("second"),
    ]
    held = HeldAlternatives(spelled, base, most_bytes)
    keys = [[a.key for each in held for a in each] for _ in range(2)]
    return keys, made, held.all_held


def test_tables_are_made_again_only_where_there_is_no_room() -> None:
    one = tables()
    size = one.record.nbytes + one.bounds.nbytes
    order = ["at hand", "first", "second"]
    assert looks(10 * size) == ([order, order], ["first", "second"], True)
    assert looks(int(1.5 * size)) == ([order, order], ["first", "second", "second"], False)
    assert looks(0) == ([order, order], ["first", "second"] * 2, False)
