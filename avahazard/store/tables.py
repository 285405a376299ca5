"""The tables (records, results), how a database stands to them, and its migrations."""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import re
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Literal

import sqlalchemy as sa
from sqlalchemy import Connection, inspect, text
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    from alembic.config import Config


NAMES = {
    "ix": "ix_%(table_name)s_%(column_0_name)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
}
Name = sa.String(200)


class Base(DeclarativeBase):
    """All tables; a Python float is a number of eight bytes in every database."""

    metadata = sa.MetaData(naming_convention=NAMES)
    type_annotation_map = {float: sa.Double(53), str: sa.Text()}  # noqa: RUF012


def _part_of(owner: str, *kind: Any, **more: Any) -> Any:
    """A column of a row that goes with its owner."""
    return mapped_column(*kind, sa.ForeignKey(owner, ondelete="CASCADE"), **more)


class PathTable(Base):
    """Paths; `id` keeps the order in which they came."""

    __tablename__ = "paths"

    id: Mapped[int] = mapped_column(primary_key=True)
    path_id: Mapped[str] = mapped_column(Name, unique=True)
    name: Mapped[str | None]
    location: Mapped[str | None]
    orientation: Mapped[str | None]
    section: Mapped[str | None]
    catchment_ha: Mapped[float | None]
    release_elevation_m: Mapped[float | None]
    observed_from: Mapped[int | None]
    observed_to: Mapped[int | None]
    observed_below_m: Mapped[float | None]


class ProfilePointTable(Base):
    """Points of the profiles, numbered from the top."""

    __tablename__ = "profile_points"

    path_id: Mapped[str] = _part_of("paths.path_id", Name, primary_key=True)
    point: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    x_m: Mapped[float]
    y_m: Mapped[float]
    land_cover: Mapped[str | None]
    easting_m: Mapped[float | None]
    northing_m: Mapped[float | None]
    crs: Mapped[str | None]
    lon: Mapped[float | None]
    lat: Mapped[float | None]
    elevation_sigma_m: Mapped[float | None]


class TerrainTable(Base):
    """The ground around paths: `data` holds `[n_rows, n_columns]` little-endian float32."""

    __tablename__ = "terrain_crops"

    path_id: Mapped[str] = _part_of("paths.path_id", Name, primary_key=True)
    crs: Mapped[str]
    west_m: Mapped[float]
    north_m: Mapped[float]
    cell_m: Mapped[float]
    n_rows: Mapped[int]
    n_columns: Mapped[int]
    data: Mapped[bytes] = mapped_column(sa.LargeBinary)


class SimulationTable(Base):
    """Runs of flow models: `data` holds peak pressures (kPa), little-endian float32, deflated."""

    __tablename__ = "simulations"

    path_id: Mapped[str] = _part_of("paths.path_id", Name, primary_key=True)
    engine: Mapped[str] = mapped_column(Name, primary_key=True)
    friction: Mapped[float] = mapped_column(primary_key=True)
    volume_m3: Mapped[float] = mapped_column(primary_key=True)
    drag_per_m: Mapped[float] = mapped_column(primary_key=True)
    ground: Mapped[str] = mapped_column(sa.String(64))
    stop_x_m: Mapped[float | None]
    left_profile: Mapped[bool]
    seconds: Mapped[float]
    n_rows: Mapped[int]
    n_columns: Mapped[int]
    data: Mapped[bytes] = mapped_column(sa.LargeBinary)


class EventTable(Base):
    """Events; `id` keeps the order in which they came."""

    __tablename__ = "events"

    id: Mapped[int] = mapped_column(primary_key=True)
    event_id: Mapped[str] = mapped_column(Name, unique=True)
    path_id: Mapped[str | None] = mapped_column(Name, sa.ForeignKey("paths.path_id"), index=True)
    date: Mapped[str | None]
    runout_elevation_m: Mapped[float | None]
    runout_x_m: Mapped[float | None]
    runout_sigma_m: Mapped[float]
    left_profile: Mapped[bool]
    release_elevation_m: Mapped[float | None]
    volume_m3: Mapped[float | None]
    deposit_length_m: Mapped[float | None]
    deposit_width_m: Mapped[float | None]
    deposit_thickness_m: Mapped[float | None]
    volume_rel_sigma: Mapped[float]
    fall_height_m: Mapped[float | None]
    runout_length_m: Mapped[float | None]
    h_over_l: Mapped[float | None]


class CovariateTable(Base):
    """Further columns of paths or events: one of `number` and `word` is set."""

    __abstract__ = True

    name: Mapped[str] = mapped_column(Name, primary_key=True)
    position: Mapped[int]
    number: Mapped[float | None]
    word: Mapped[str | None]


class PathCovariateTable(CovariateTable):
    """Further columns of paths."""

    __tablename__ = "path_covariates"

    path_id: Mapped[str] = _part_of("paths.path_id", Name, primary_key=True, sort_order=-1)


class EventCovariateTable(CovariateTable):
    """Further columns of events."""

    __tablename__ = "event_covariates"

    event_id: Mapped[str] = _part_of("events.event_id", Name, primary_key=True, sort_order=-1)


class SpeedTable(Base):
    """Measured speeds; one of `x_m` and `elevation_m` is set."""

    __tablename__ = "speeds"

    id: Mapped[int] = mapped_column(primary_key=True)
    event_id: Mapped[str] = _part_of("events.event_id", Name, index=True)
    x_m: Mapped[float | None]
    elevation_m: Mapped[float | None]
    speed_m_s: Mapped[float]
    speed_sigma_m_s: Mapped[float]


class ModelTable(Base):
    """Models by name; a child names its parent. The effect file is kept as text, never run."""

    __tablename__ = "models"

    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(Name, unique=True)
    parent: Mapped[str | None] = mapped_column(Name, sa.ForeignKey("models.name"))
    specification: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    effect_file: Mapped[str | None] = mapped_column(sa.Text)
    effect_sha256: Mapped[str | None] = mapped_column(sa.String(64))
    created: Mapped[dt.datetime] = mapped_column(sa.DateTime)


class Sealed(Base):
    """A row with the SHA-256 of what it holds, and of where that belongs."""

    __abstract__ = True

    sha256: Mapped[str] = mapped_column(sa.String(64))

    def digest(self) -> str:
        """What `sha256` should be; the same before the row is stored and after it is read."""
        raise NotImplementedError


@sa.event.listens_for(Sealed, "before_insert", propagate=True)
def _seal(_mapper: object, _connection: object, row: Sealed) -> None:
    row.sha256 = row.digest()


def _hash(text: str, data: bytes = b"") -> str:
    return hashlib.sha256(text.encode() + data).hexdigest()


def _sorted(document: Any) -> str:
    # The order of keys in the database is nobody's business.
    return json.dumps(document, sort_keys=True, ensure_ascii=False)


class ResultTable(Sealed):
    """What a command found by a model: the document that it prints."""

    __abstract__ = True

    id: Mapped[int] = mapped_column(primary_key=True)
    model: Mapped[str] = _part_of("models.name", Name, index=True)
    result: Mapped[Any] = mapped_column(sa.JSON)
    created: Mapped[dt.datetime] = mapped_column(sa.DateTime)

    def digest(self) -> str:
        """Of the document by its model; keys become texts in the database."""
        return _hash(f"{self.model}\n{_sorted(json.loads(json.dumps(self.result)))}")


class CalibrationTable(ResultTable):
    """One run of a sampler, by `calibrate` or `add`."""

    __tablename__ = "calibrations"

    settings: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    seed: Mapped[int] = mapped_column(sa.BigInteger)
    data_fingerprint: Mapped[str] = mapped_column(sa.String(64))
    diagnostics: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    converged: Mapped[bool]


class DrawChunkTable(Sealed):
    """Draws `[n_chains, n_draws]` of one parameter, cut along the draws: little-endian float64."""

    __tablename__ = "draw_chunks"

    calibration: Mapped[int] = _part_of("calibrations.id", primary_key=True)
    parameter: Mapped[str] = mapped_column(Name, primary_key=True)
    chunk: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    n_chains: Mapped[int]
    n_draws: Mapped[int]
    data: Mapped[bytes] = mapped_column(sa.LargeBinary)

    def digest(self) -> str:
        """Of the draws, their shape, and their place."""
        shape = f"{self.n_chains} {self.n_draws}"
        return _hash(f"{self.calibration}\n{self.parameter}\n{self.chunk}\n{shape}\n", self.data)


class ComparisonTable(ResultTable):
    """Scores of a model against the measurements, by `compare`."""

    __tablename__ = "comparisons"


class DiagnosisTable(ResultTable):
    """Which effect a model lacks, by `diagnose`."""

    __tablename__ = "diagnoses"


class PathRunTable(Base):
    """A run of `hazard` or `zones` by the `key` of its `settings`; not `finished`: interrupted."""

    __tablename__ = "path_runs"

    id: Mapped[int] = mapped_column(primary_key=True)
    kind: Mapped[str] = mapped_column(sa.String(20))
    model: Mapped[str] = _part_of("models.name", Name, index=True)
    key: Mapped[str] = mapped_column(sa.String(64))
    settings: Mapped[dict[str, Any]] = mapped_column(sa.JSON)
    created: Mapped[dt.datetime] = mapped_column(sa.DateTime)
    finished: Mapped[dt.datetime | None] = mapped_column(sa.DateTime)


class PathResultTable(Sealed):
    """What was found on one path of a run, a list of documents, with notes; or why nothing was."""

    __tablename__ = "path_results"

    run: Mapped[int] = _part_of("path_runs.id", primary_key=True)
    position: Mapped[int] = mapped_column(primary_key=True, autoincrement=False)
    path_id: Mapped[str] = mapped_column(Name)
    result: Mapped[list[Any]] = mapped_column(sa.JSON)
    notes: Mapped[list[Any]] = mapped_column(sa.JSON)
    failed: Mapped[str | None] = mapped_column(sa.Text)

    def digest(self) -> str:
        """Of the whole row, whose keys are all texts."""
        place = [self.run, self.position, self.path_id]
        return _hash(_sorted([*place, self.result, self.notes, self.failed]))


State = Literal["empty", "foreign", "old", "current", "newer"]
_REVISION = re.compile(r"^(revision|down_revision) = (?:None|[\"'](.+)[\"'])$", re.MULTILINE)


def state(connection: Connection) -> State:
    """Return how a schema stands to this program: `foreign` is another's, `newer` not known."""
    current = revision(connection)
    if current is None:
        return "foreign" if inspect(connection).get_table_names() else "empty"
    if current == head():
        return "current"
    return "old" if current in _revisions() else "newer"


def revision(connection: Connection) -> str | None:
    """Return the revision of a database, None where it has none."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    found: str | None = connection.scalar(text("SELECT version_num FROM alembic_version"))
    return found


def head() -> str | None:
    """Return the revision that this program works with."""
    revisions = _revisions()
    return next((name for name in revisions if name not in revisions.values()), None)


def _revisions() -> dict[str, str | None]:
    """Each revision and the one before it, read off the migrations' files.

    Alembic would run them all, and takes longer to load than most commands to run.
    """
    found: dict[str, str | None] = {}
    for file in (files("avahazard.migrations") / "versions").iterdir():
        if file.name.endswith(".py"):
            names = dict(_REVISION.findall(file.read_text(encoding="utf-8")))
            if names.get("revision"):
                found[names["revision"]] = names.get("down_revision") or None
    return found


def require_current(connection: Connection) -> None:
    """Refuse a database whose schema is not that of this program, with the remedy."""
    found = state(connection)
    if found == "current":
        return
    message, hint = {
        "empty": ("The database is empty.", "Create its tables with `avahazard init`."),
        "foreign": (
            "The database holds other tables, not those of avahazard.",
            "Name another database with --db.",
        ),
        "old": (
            "The database was made by an older version of avahazard.",
            "Bring it up to date with `avahazard db upgrade` (`avahazard db backup` first).",
        ),
        "newer": (
            "The database was made by a newer version of avahazard.",
            "Update the program: this version does not know its tables.",
        ),
    }[found]
    raise AvahazardError(message, hint)


def upgrade(connection: Connection) -> None:
    """Run the migrations that `connection`'s database lacks."""
    from alembic import command  # noqa: PLC0415 (slow, and rarely needed)

    config = _config()
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _config() -> Config:
    from alembic.config import Config  # noqa: PLC0415 (slow, and rarely needed)

    config = Config()
    # A percent sign in the folder's name would be taken for an interpolation.
    folder = str(files("avahazard.migrations")).replace("%", "%%")
    config.set_main_option("script_location", folder)
    return config
