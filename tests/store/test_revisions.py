"""The revisions read off the files of the migrations, against Alembic's own reading."""

from __future__ import annotations

from alembic.script import ScriptDirectory

from avahazard.store import schema


def test_revisions_are_those_that_alembic_finds() -> None:
    script = ScriptDirectory.from_config(schema._config())
    assert schema.head() == script.get_current_head()
    assert schema._revisions() == {r.revision: r.down_revision for r in script.walk_revisions()}
