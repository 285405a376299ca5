"""Many users at once: nobody is refused, nothing confirmed is lost, no reader sees a part."""

from __future__ import annotations

import multiprocessing
import time
from collections import Counter
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import text

from avahazard.records.errors import AvahazardError
from avahazard.store.session import reading
from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import check
from avahazard.workflow.import_files import import_files
from avahazard.workflow.models import show_models

N_ROWS = 50
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


def mix(place: str, database: str, folder: Path, seconds: float, *, threads: bool = False) -> Crowd:
    """Let the eight `ROLES` work on an empty database for some `seconds`."""
    _write(folder / "first.csv", "shared", 0, N_ROWS)
    import_files(database, [folder / "first.csv"])
    users = [(role, k, database, str(folder), seconds) for k, role in enumerate(ROLES)]
    with _pool(len(users), threads) as pool:
        done = list(pool.map(_work, users))
    turns = Counter(dict.fromkeys(ROLES, 0))
    for one in done:
        turns[one.role] += one.turns
    lost, rows = 0, 0
    with reading(database) as session:
        found = Counter(_owners(session.scalars(text("SELECT event_id FROM events")).all()))
        for one in done:
            if one.role == "import":
                rows += one.turns * N_ROWS
                lost += one.turns * N_ROWS - found[f"u{one.user}"]
            if one.role == "update":
                query = text("SELECT count(*) FROM events WHERE event_id LIKE :mine")
                rows += 1
                mine = f"shared-{one.user}"
                newest = session.scalar(
                    text("SELECT runout_length_m FROM events WHERE event_id = :mine"),
                    {"mine": mine},
                )
                lost += newest != 1500.0 + one.turns if one.turns else 0
                assert session.scalar(query, {"mine": "shared-%"}) == N_ROWS
        models = session.scalar(text("SELECT count(*) FROM models"))
    rows += turns["calibrate"]
    lost += turns["calibrate"] - models
    faults = [fault for one in done for fault in one.faults]
    faults += check(database).problems
    return Crowd(place, "mixed work", len(users), dict(turns), rows, lost, faults)


def large_imports(
    place: str, database: str, folder: Path, n_users: int, n_rows: int, *, threads: bool = False
) -> Crowd:
    """Let `n_users` import `n_rows` events each, all at once."""
    files = []
    for k in range(n_users):
        files.append(folder / f"large{k}" / "events.csv")
        files[-1].parent.mkdir()
        _write(files[-1], f"u{k}", 0, n_rows)
    with _pool(n_users, threads) as pool:
        refused = list(pool.map(_import, [(database, str(file)) for file in files]))
    with reading(database) as session:
        found = Counter(_owners(session.scalars(text("SELECT event_id FROM events")).all()))
    lost = sum(n_rows - found[f"u{k}"] for k in range(n_users))
    faults = [fault for fault in refused if fault] + list(check(database).problems)
    turns = {"import": n_users - sum(map(bool, refused))}
    return Crowd(place, "large imports", n_users, turns, n_users * n_rows, lost, faults)


def _work(given: tuple[str, int, str, str, float]) -> Used:
    role, user, database, folder, seconds = given
    used = Used(role, user)
    mine = Path(folder) / f"user{user}"
    mine.mkdir()
    until = time.monotonic() + seconds
    seen = 0
    while time.monotonic() < until:
        try:
            if role == "read":
                seen = _read(database, seen, used)
            else:
                _turn(role, user, used.turns, database, mine)
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
        file.write_text(
            f"event_id,fall_height_m,runout_length_m\nshared-{user},900,{1501 + turn}\n",
            encoding="utf-8",
        )
        import_files(database, [file], update=True)
    else:
        calibrate(database, f"m{user}-{turn}", law="power", chains=2, draws=40)


def _read(database: str, seen: int, used: Used) -> int:
    with reading(database) as session:
        ids = session.scalars(text("SELECT event_id FROM events")).all()
        again = session.scalar(text("SELECT count(*) FROM events"))
    if len(ids) % N_ROWS or len(ids) < seen or again != len(ids):
        used.faults.append(f"read: {len(ids)} events, {again} a moment later, {seen} before")
    show_models(database)
    return len(ids)


def _import(given: tuple[str, str]) -> str:
    try:
        import_files(given[0], [given[1]])
    except AvahazardError as error:
        return error.message
    return ""


def _owners(event_ids: list[str]) -> list[str]:
    return [name.split("-")[0] for name in event_ids]


def _write(file: Path, owner: str, first: int, n: int) -> None:
    rows = "".join(
        f"{owner}-{k},900,{1500 + (k if owner == 'shared' else k % 700)},{1000 + 50 * (k % 90)}\n"
        for k in range(first, first + n)
    )
    text_ = f"event_id,fall_height_m,runout_length_m,volume_m3\n{rows}"
    file.write_text(text_, encoding="utf-8")


def _pool(n: int, threads: bool) -> Executor:
    if threads:
        return ThreadPoolExecutor(n)
    return ProcessPoolExecutor(n, mp_context=multiprocessing.get_context("spawn"))
