"""The work that a power cut ends (run by power.py): imports, then a calibration.

Words: the database, `alone` or `held` (another connection keeps the log open), what `synchronous`
is to be (FULL is the program's own; any other shows that the study sees losses), files to
import, and `calibrate`.
"""

from __future__ import annotations

import sqlite3
import sys
from pathlib import Path

from sqlalchemy import event
from sqlalchemy.engine import Engine

from avahazard.workflow.import_files import import_files


def main() -> None:
    """Do all, and print a line when a part is confirmed."""
    database, holder, synchronous, *files = sys.argv[1:]
    if synchronous != "FULL":
        event.listen(
            Engine,
            "begin",
            lambda c: c.exec_driver_sql(f"PRAGMA synchronous = {synchronous}"),
            insert=True,
        )
    other = sqlite3.connect(database) if holder == "held" else None
    if other is not None:
        other.execute("SELECT count(*) FROM events").fetchone()
    for file in files:
        if file == "calibrate":
            from avahazard.workflow.calibrate import calibrate  # noqa: PLC0415 (slow to load)

            calibrate(database, "model", law="power", chains=2, draws=40)
            print("calibrated model", flush=True)
        else:
            import_files(database, [Path(file)])
            print(f"imported {Path(file).parent.name}", flush=True)
    if other is not None:
        other.close()


if __name__ == "__main__":
    main()
