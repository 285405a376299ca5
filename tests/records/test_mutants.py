"""Mutants of the new forms: each is read or refused; no traceback, and nothing partial."""

from __future__ import annotations

import logging
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from avahazard.records.errors import AvahazardError
from avahazard.store.records import load_records
from avahazard.store.session import reading
from avahazard.workflow.database import import_files, init_database
from avahazard.workflow.requests import ImportRequest
from tests.records.mutants import mutant, seeds

PATHS = "path_id,release_elevation_m\nP,2200\n"


@pytest.mark.parametrize(
    "n", [200, pytest.param(20_000, marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_mutants_are_read_or_refused(tmp_path: Path, n: int) -> None:
    logging.getLogger("rasterio").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore")
    database = str(tmp_path / "mutants.db")
    init_database(database)
    (tmp_path / "paths.csv").write_text(PATHS, encoding="utf-8")
    import_files(database, [tmp_path / "paths.csv"])
    with reading(database) as session:
        before = load_records(session)
    inputs = seeds(tmp_path)
    of_gis = {source: source.suffix in (".kml", ".gpx") for source, _ in inputs}
    for source, _ in inputs:  # as they are, all are read
        dem = tmp_path / "dem.tif" if of_gis[source] else None
        import_files(database, [source], ImportRequest(dem=dem, dry_run=True))
    outcomes: Counter[str] = Counter()
    for k in range(n):
        rng = np.random.default_rng([4, k])
        source, files = inputs[k % len(inputs)]
        file = files[int(rng.integers(len(files)))]
        whole = file.read_bytes()
        file.write_bytes(mutant(whole, rng))
        try:
            # A dry run does all but store, from one transaction.
            dem = tmp_path / "dem.tif" if of_gis[source] else None
            import_files(database, [source], ImportRequest(dem=dem, dry_run=k % 50 != 0))
            outcomes["read"] += 1
            if k % 50 == 0:
                outcomes["stored"] += 1
                database = _anew(tmp_path, k)
        except AvahazardError as error:
            outcomes["refused"] += 1
            if not error.hint:
                raise AssertionError(f"mutant {k} of {file.name}: no hint") from error
            if k % 50 == 0:
                with reading(database) as session:
                    assert load_records(session) == before, (k, file.name)
        except Exception as error:
            raise AssertionError(f"mutant {k} of {file.name}: {error!r}") from error
        finally:
            file.write_bytes(whole)
    print(outcomes)
    assert outcomes["read"] + outcomes["refused"] == n
    assert outcomes["refused"] > 0.2 * n


def _anew(folder: Path, k: int) -> str:
    database = str(folder / f"mutants-{k}.db")
    init_database(database)
    import_files(database, [folder / "paths.csv"])
    return database
