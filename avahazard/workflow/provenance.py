"""What a stored model was made of, and with."""

from __future__ import annotations

import hashlib
from importlib.metadata import version
from pathlib import Path

import avahazard
from avahazard.records.fingerprint import data_fingerprint
from avahazard.records.lookup import only_paths
from avahazard.results.models import Provenance, Surroundings
from avahazard.store.models import load_model
from avahazard.store.records import load_records
from avahazard.store.results import latest_calibration
from avahazard.store.session import reading

PACKAGES = ("numpy", "scipy", "numba", "plotly")
LOCK = Path(avahazard.__file__).parents[1] / "requirements.lock"


def surroundings() -> Surroundings:
    """Versions and lock file of the running program."""
    versions = {"avahazard": avahazard.__version__} | {name: version(name) for name in PACKAGES}
    lock = hashlib.sha256(LOCK.read_bytes()).hexdigest() if LOCK.is_file() else None
    return Surroundings(versions, lock)


def show_provenance(database: str, name: str) -> Provenance:
    """What is needed to make the model `name` again.

    Raises:
        AvahazardError: there is no such model.
    """
    with reading(database) as session:
        model = load_model(session, name)
        calibration = latest_calibration(session, name)
        records = load_records(session)
    kept, settings = model.specification, calibration.settings
    made_with = settings.get("made_with")
    training = only_paths(records, tuple(kept["paths"]))
    return Provenance(
        model=name,
        parent=model.parent,
        created=f"{model.created.isoformat(timespec='seconds')}Z",
        data_fingerprint=calibration.data_fingerprint,
        records_changed=data_fingerprint(training) != calibration.data_fingerprint,
        specification=kept["specification"],
        method=kept["method"],
        paths=tuple(kept["paths"]),
        chains=settings["chains"],
        draws=settings["draws"],
        seed=calibration.seed,
        effect_sha256=model.effect_sha256,
        made_with=None if made_with is None else Surroundings.from_dict(made_with),
        now=surroundings(),
    )
