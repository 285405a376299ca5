"""What is stored of models."""

from __future__ import annotations

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.records.plain import plain
from avahazard.store.records import save_records
from avahazard.store.session import writing
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.models import show_model, show_models
from avahazard.workflow.requests import CalibrateRequest
from tests.workflow.twin import twin_records


def test_models_in_short_and_in_full(database: str) -> None:
    with writing(database) as session:
        save_records(session, twin_records())
    assert show_models(database) == ()
    document = calibrate(database, "one", CalibrateRequest(method="gibbs", chains=2, draws=100))
    calibrate(
        database, "two", CalibrateRequest(method="metropolis", law="power", chains=2, draws=100)
    )
    one, two = show_models(database)
    assert (one.model, one.law, one.method) == ("one", "exponential", "gibbs")
    assert (two.model, two.law, two.converged) == ("two", "power", two.converged)
    shown = show_model(database, "one")
    assert shown.created == one.created
    assert shown.n_events == one.n_events
    assert one.created.endswith("Z")
    assert shown.to_dict() == {**plain(document), "created": shown.created}
    with pytest.raises(AvahazardError, match="no model three") as error:
        show_model(database, "three")
    assert "one, two" in error.value.hint
