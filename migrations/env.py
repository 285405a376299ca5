"""Runs the migrations: inside a command on its connection, or by `alembic` on AVAHAZARD_DB."""

from __future__ import annotations

import os

from alembic import context
from sqlalchemy import Connection

from avahazard.store.session import make_engine
from avahazard.store.tables import Base


def run(connection: Connection) -> None:
    """Run on an open connection; SQLite changes a table by copying it."""
    context.configure(connection=connection, target_metadata=Base.metadata, render_as_batch=True)
    with context.begin_transaction():
        context.run_migrations()


given: Connection | None = context.config.attributes.get("connection")
if given is not None:
    run(given)
else:
    engine = make_engine(os.environ.get("AVAHAZARD_DB", "avahazard.db"), migrates=True)
    with engine.begin() as own:
        run(own)
