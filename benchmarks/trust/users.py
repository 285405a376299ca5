"""Many users at once: nobody is refused, nothing confirmed is lost, no reader sees a part."""

from __future__ import annotations

import multiprocessing
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store import upkeep
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import check, import_files
from avahazard.workflow.listing import show_models
from avahazard.workflow.requests import CalibrateRequest, ImportRequest
from benchmarks.study import Line, bullets, table
from benchmarks.trust.places import places

N_ROWS, N_USERS = 50, 6
ROLES = ("import", "import", "update", "update", "calibrate", "read", "read", "read")
"""What each of eight users does, over and over."""


@dataclass(slots=True)
class Used:
    """What one user did: turns that were confirmed, and what was refused or seen in part."""

    role: str
    user: int
    turns: int = 0
    faults: list[str] = field(default_factory=list)


@dataclass(slots=True)
class Crowd:
    """What a crowd did to one database."""

    place: str
    what: str
    users: int
    turns: dict[str, int]
    rows: int
    lost: int
    faults: list[str]


def users(given: Any, folder: Path) -> Line:
    """Eight users for a while, and six large imports at once."""
    rows = []
    for place in places():
        for what in ("mix", "large"):
            inside = folder / f"{place.name}-{what}"
            inside.mkdir()
            database = place.new(inside)
            upkeep.create(database)
            if what == "mix":
                done = mix(place.name, database, inside, given.seconds)
            else:
                done = large_imports(place.name, database, inside, N_USERS, given.rows)
            place.drop(database)
            rows.append(asdict(done))
            print(rows[-1])
    return {"rows": rows}


def page(found: Line) -> str:
    """A row for each crowd."""
    rows = [
        (row["place"], row["users"], ", ".join(f"{n:,} {role}" for role, n in row["turns"].items()),
         row["rows"], row["lost"], len(row["faults"]))
        for row in found["rows"]
    ]  # fmt: skip
    return (
        table(("database", "users", "turns", "confirmed rows", "lost", "refused"), rows)
        + "\n\n"
        + bullets([f for row in found["rows"] for f in row["faults"]], "No user was refused.")
    )


def mix(place: str, database: str, folder: Path, seconds: float, *, threads: bool = False) -> Crowd:
    """Let the eight `ROLES` work on an empty database for some `seconds`."""
    _write(folder / "first.csv", "shared", 0, N_ROWS)
    import_files(database, [folder / "first.csv"])
    given = [(role, k, database, folder, seconds) for k, role in enumerate(ROLES)]
    done = _at_once(_work, given, threads)
    turns = Counter(dict.fromkeys(ROLES, 0))
    for one in done:
        turns[one.role] += one.turns
    lost, rows = 0, turns["calibrate"]
    with reading(database) as session:
        length = dict(session.execute(text("SELECT event_id, runout_length_m FROM events")).all())
        found = Counter(name.split("-")[0] for name in length)
        for one in done:
            if one.role == "import":
                rows += one.turns * N_ROWS
                lost += one.turns * N_ROWS - found[f"u{one.user}"]
            elif one.role == "update":
                rows += 1
                lost += one.turns > 0 and length[f"shared-{one.user}"] != 1500.0 + one.turns
        assert found["shared"] == N_ROWS
        lost += turns["calibrate"] - session.scalar(text("SELECT count(*) FROM models"))
    faults = [fault for one in done for fault in one.faults] + list(check(database).problems)
    return Crowd(place, "mixed work", len(given), dict(turns), rows, lost, faults)


def large_imports(
    place: str, database: str, folder: Path, n_users: int, n_rows: int, *, threads: bool = False
) -> Crowd:
    """Let `n_users` import `n_rows` events each, all at once."""
    files = [folder / f"large{k}" / "events.csv" for k in range(n_users)]
    for k, file in enumerate(files):
        file.parent.mkdir()
        _write(file, f"u{k}", 0, n_rows)
    refused = _at_once(_import, [(database, file) for file in files], threads)
    with reading(database) as session:
        found = session.scalar(text("SELECT count(*) FROM events"))
    faults = [fault for fault in refused if fault] + list(check(database).problems)
    turns = {"import": n_users - sum(map(bool, refused))}
    rows = n_users * n_rows
    return Crowd(place, "large imports", n_users, turns, rows, rows - found, faults)


def _at_once(
    work: Callable[..., Any], given: Sequence[tuple[Any, ...]], threads: bool
) -> list[Any]:
    """Call `work` once for each user, by threads or by processes."""
    spawn = multiprocessing.get_context("spawn")
    n = len(given)
    with ThreadPoolExecutor(n) if threads else ProcessPoolExecutor(n, mp_context=spawn) as pool:
        return list(pool.map(work, *zip(*given, strict=True)))


def _work(role: str, user: int, database: str, folder: Path, seconds: float) -> Used:
    used = Used(role, user)
    selected = folder / f"user{user}"
    selected.mkdir()
    until, seen = time.monotonic() + seconds, 0
    while time.monotonic() < until:
        try:
            if role == "read":
                seen = _read(database, seen, used)
            else:
                _turn(role, user, used.turns, database, selected)
            used.turns += 1
        except AvahazardError as error:
            used.faults.append(f"{role}: {error.message}")
    return used


def _turn(role: str, user: int, turn: int, database: str, folder: Path) -> None:
    file = folder / "events.csv"
    if role == "import":
        _write(file, f"u{user}", turn * N_ROWS, N_ROWS)
        import_files(database, [file])
    elif role == "update":
        row = f"shared-{user},900,{1501 + turn}"
        file.write_text(f"event_id,fall_height_m,runout_length_m\n{row}\n", encoding="utf-8")
        import_files(database, [file], ImportRequest(update=True))
    else:
        calibrate(database, f"m{user}-{turn}", CalibrateRequest(law="power", chains=2, draws=50))


def _read(database: str, seen: int, used: Used) -> int:
    with reading(database) as session:
        ids = session.scalars(text("SELECT event_id FROM events")).all()
        again = session.scalar(text("SELECT count(*) FROM events"))
    if len(ids) % N_ROWS or len(ids) < seen or again != len(ids):
        used.faults.append(f"read: {len(ids)} events, {again} a moment later, {seen} before")
    show_models(database)
    return len(ids)


def _import(database: str, file: Path) -> str:
    try:
        import_files(database, [file])
    except AvahazardError as error:
        return error.message
    return ""


def _write(file: Path, owner: str, first: int, n: int) -> None:
    rows = "".join(
        f"{owner}-{k},900,{1500 + (k if owner == 'shared' else k % 700)},{1000 + 50 * (k % 90)}\n"
        for k in range(first, first + n)
    )
    head = "event_id,fall_height_m,runout_length_m,volume_m3\n"
    file.write_text(head + rows, encoding="utf-8")
