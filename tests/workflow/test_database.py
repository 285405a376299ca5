"""A full check: models are calibrated again."""

from __future__ import annotations

import json

from sqlalchemy import text

from avahazard.store.session import writing
from avahazard.store.tables import DrawChunkTable
from avahazard.workflow.database import check


def test_a_full_check_gives_the_draws_that_are_stored(snow_database: str) -> None:
    (found,) = check(snow_database, full=True).recomputed or ()
    assert (found.model, found.identical, found.why_not) == ("base", True, None)
    # An edit that brings its own checksum along passes every check but that of the sampler.
    with writing(snow_database) as session:
        row = session.get(DrawChunkTable, (1, "a", 0))
        assert row is not None
        data = bytearray(row.data)
        data[0] ^= 1
        row.data = bytes(data)
        row.sha256 = row.digest()
    assert check(snow_database).whole
    found_again = check(snow_database, full=True)
    assert not found_again.whole
    assert "base calibrated again has other draws" in found_again.problems[0]


def test_what_cannot_be_done_again_says_why(snow_database: str) -> None:
    with writing(snow_database) as session:
        session.execute(text("UPDATE events SET volume_m3 = 1.01 * volume_m3"))
    checked = check(snow_database, full=True)
    (found,) = checked.recomputed or ()
    assert checked.whole
    assert found.identical is None
    assert "records have changed" in str(found.why_not)
    assert json.loads(json.dumps(checked.to_dict()))["recomputed"][0]["model"] == "base"
