"""Kills, power cuts, bad disks, many users and upgrades, counted."""

from __future__ import annotations

import shutil
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from avahazard.store import upkeep
from benchmarks.trust.amounts import Amounts, Tell, cut
from benchmarks.trust.disks import can_mount, disturb
from benchmarks.trust.jobs import JOBS, write_records
from benchmarks.trust.kills import kill_jobs
from benchmarks.trust.places import Files, places
from benchmarks.trust.power import can_cut, cut_power
from benchmarks.trust.power_server import can_cut_server, cut_server_power
from benchmarks.trust.upgrades import earlier_revisions, upgrade_all
from benchmarks.trust.users import large_imports, mix

N_USERS = 6


def kills(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """kill -9 over all writing commands, shared among the databases."""
    write_records(folder)
    found = []
    jobs = [job for job in JOBS if amounts.only in ("", job.name)]
    mine = [place for place in places() if isinstance(place, Files) or jobs[0].on_server]
    for place in mine:
        rng = np.random.default_rng([amounts.seed, len(place.name)])
        inside = folder / place.name
        inside.mkdir()
        for name in ("world", "changed"):
            (inside / name).symlink_to(folder / name)
        shutil.copy(folder / "avahazard.toml", inside)
        for one in kill_jobs(jobs, place, amounts.kills // len(mine), rng, inside):
            tell(f"{place.name}: {one.job} after {one.moment:.1f} s, {one.stood} {one.faults}")
            found.append(one)
    rows = []
    for place in mine:
        for job in JOBS:
            there = [one for one in found if (one.place, one.job) == (place.name, job.name)]
            if there:
                stood = Counter(one.stood for one in there)
                rows.append({"place": place.name, "job": job.name, "kills": len(there), **stood})
    faults = [f"{one.place}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "faults": cut(faults)}


def power(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Power cuts; with weaker syncs too, which shows that the study sees losses."""
    if not can_cut():
        return {"skipped": "no gcc here to build what logs the writes"}
    rows = []
    for k, (holder, synchronous) in enumerate(
        (("alone", "FULL"), ("held", "FULL"), ("held", "NORMAL"), ("alone", "OFF"))
    ):
        inside = folder / str(k)
        inside.mkdir()
        rng = np.random.default_rng([amounts.seed, k])
        n = amounts.cuts if synchronous == "FULL" else min(amounts.cuts, 100)
        rows.append(asdict(cut_power(inside, n, rng, holder=holder, synchronous=synchronous)))
        tell(str(rows[-1]))
    for k, synchronous in enumerate(("on", "off") if can_cut_server() else ()):
        inside = folder / f"server-{k}"
        inside.mkdir()
        rng = np.random.default_rng([amounts.seed, k, len("server")])
        n = amounts.cuts if synchronous == "on" else min(amounts.cuts, 100)
        rows.append(asdict(cut_server_power(inside, n, rng, synchronous=synchronous)))
        tell(str(rows[-1]))
    return {"rows": rows}


def disks(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Full disks, read-only and vanishing folders, clocks that jump."""
    write_records(folder)
    found = []
    for one in disturb(JOBS, amounts.sizes, np.random.default_rng(amounts.seed), folder):
        tell(f"{one.fault}: {one.job}, {'told' if one.told else 'done'} {one.faults}")
        found.append(one)
    kinds = list(dict.fromkeys(one.fault for one in found))
    rows = [
        {
            "fault": kind,
            "commands": sum(one.fault == kind for one in found),
            "told": sum(one.fault == kind and one.told for one in found),
        }
        for kind in kinds
    ]
    faults = [f"{one.fault}, {one.job}: {fault}" for one in found for fault in one.faults]
    return {"rows": rows, "mounted": can_mount(), "faults": cut(faults)}


def users(amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Eight users for a while, and six large imports at once."""
    rows = []
    for place in places():
        for what in ("mix", "large"):
            inside = folder / f"{place.name}-{what}"
            inside.mkdir()
            database = place.new(inside)
            upkeep.create(database)
            done = (
                mix(place.name, database, inside, amounts.seconds)
                if what == "mix"
                else large_imports(place.name, database, inside, N_USERS, amounts.rows)
            )
            place.drop(database)
            tell(str(done))
            rows.append(asdict(done))
    return {"rows": rows, "seconds": amounts.seconds, "rows_of_import": amounts.rows}


def upgrades(_amounts: Amounts, folder: Path, tell: Tell) -> dict[str, Any]:
    """Databases of every earlier revision."""
    write_records(folder)
    rows = []
    for place in places():
        inside = folder / place.name
        inside.mkdir()
        for name in ("world", "changed"):
            (inside / name).symlink_to(folder / name)
        for one in upgrade_all(place, inside, earlier_revisions()):
            tell(str(one))
            rows.append(asdict(one))
    return {"rows": rows}
