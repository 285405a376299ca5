"""Sections of docs/trust.md: kills, power, disks, users, upgrades."""

from __future__ import annotations

from benchmarks.trust.markdown import Found, command, listed, table

STOOD = ("kills", "before", "between", "after")


def kills(found: Found) -> list[str]:
    runs = found["runs"]
    rows = [row for run in runs for row in run["rows"]]
    faults = [fault for run in runs for fault in run["faults"]]
    notes = [line for run in runs if "note" in run for line in (run["note"], "")]
    total = sum(row["kills"] for row in rows)
    places = list(dict.fromkeys(row["place"] for row in rows))
    jobs = list(dict.fromkeys(row["job"] for row in rows))
    lines = []
    for job in jobs:
        mine = [row for row in rows if row["job"] == job]
        lines.append([f"`{job}`", *(sum(row.get(k, 0) for row in mine) for k in STOOD)])
    return [
        "## kill -9",
        "",
        *(line for run in runs for line in (_kills_command(run), "")),
        f"{total} kills on {' and '.join(places)}. The command runs in a process forked off one "
        "that has loaded the program and done it before, so that it is killed at what it is for: "
        "half of those that write to the database within 5 ms of a random one of the statements "
        "by which they write, the others at any moment. After each: the rows are those of before, "
        "those of the command, or (bounds, path by path; the steps of `run`) some of the latter; "
        "records and models are whole; what had been confirmed is there; `db check --full` finds "
        "nothing; the same command, run again, ends as if nothing had happened; no file is half "
        "written.",
        "",
        *table(("command", "kills", "stood as before", "in between", "as after"), lines),
        *listed(faults, "Nothing was lost, half stored or damaged; no command was refused."),
        *notes,
    ]


def _kills_command(run: Found) -> str:
    only = run["amounts"].get("only")
    whole = command("kills", run, "kills")
    return f'{whole.removesuffix("`")} --only "{only}"`' if only else whole


def power(found: Found) -> list[str]:
    title = ["## Power cuts", "", command("power", found, "cuts"), ""]
    if "skipped" in found:
        return [*title, f"Not run: {found['skipped']}.", ""]
    lines = [
        (
            _synced(row),
            row["n_cuts"],
            row["n_confirmed"],
            row["lost"],
            row["partial"],
            row["damaged"],
        )
        for row in found["rows"]
    ]
    server = any(row["holder"] == "server" for row in found["rows"])
    return [
        *title,
        "A library that is loaded before the program's own logs every write, sync, rename and "
        "removal of four imports and a calibration. A cut falls at a random place of that log: "
        "what was synced is on the disk; of the rest none, all, or a random part, torn at 512 "
        "bytes. "
        + (
            "On SQLite it is the program's own files that are logged, on PostgreSQL those of all "
            "processes of the server, which then recovers by itself. "
            if server
            else "PostgreSQL's own log was not studied here. "
        )
        + "The program syncs in full (`synchronous = FULL`, and a server's own "
        "`synchronous_commit = on`); the rows with less show that the study sees losses.",
        "",
        *table(("sync", "cuts", "confirmed", "lost", "in part", "damaged"), lines),
    ]


def _synced(row: Found) -> str:
    if row["holder"] == "server":
        return f"PostgreSQL, {row['synchronous']}"
    return f"SQLite, {row['synchronous']}{', log held open' if row['holder'] == 'held' else ''}"


def disks(found: Found) -> list[str]:
    lines = [(row["fault"], row["commands"], row["told"]) for row in found["rows"]]
    missing = "" if found["mounted"] else " Disks of one's own could not be mounted here."
    return [
        "## Disks and clocks",
        "",
        command("disks", found, "sizes"),
        "",
        "The writing commands on a disk (in memory, of its own) that fills at a random place, on a "
        "read-only one, in a folder that is taken away meanwhile, and by a clock that jumps ten "
        "years "
        "to and fro at every third reading. Each ended well, or with one message and its remedy; "
        "the "
        f"database was whole, and what had not ended well did so when it was run again.{missing}",
        "",
        *table(("fault", "commands", "ended by a message"), lines),
        *listed(found["faults"], "No traceback, no message without a remedy, nothing half stored."),
    ]


def users(found: Found) -> list[str]:
    lines = []
    for row in found["rows"]:
        turns = ", ".join(f"{n:,} {role}" for role, n in row["turns"].items())
        lines.append(
            (row["place"], row["users"], turns, row["rows"], row["lost"], len(row["faults"]))
        )
    faults = [fault for row in found["rows"] for fault in row["faults"]]
    return [
        "## Many users",
        "",
        command("users", found, "seconds", "rows"),
        "",
        f"Eight processes for {found['seconds']:g} s (imports, updates, calibrations, readers), "
        "then six "
        f"imports of {found['rows_of_import']:,} events each at once. Readers check that they see "
        "whole imports only, and no fewer than before.",
        "",
        *table(("database", "users", "turns", "confirmed rows", "lost", "refused"), lines),
        *listed(faults, "Nobody was refused."),
    ]


def upgrades(found: Found) -> list[str]:
    rows = found["rows"]
    places = list(dict.fromkeys(row["place"] for row in rows))
    revisions = list(dict.fromkeys(row["revision"] for row in rows))
    lines = []
    for revision in revisions:
        mine = [row for row in rows if row["revision"] == revision]
        lines.append(
            (revision, mine[0]["n_rows"], len(mine), sum(bool(row["faults"]) for row in mine))
        )
    faults = [f"{row['place']}, {row['revision']}: {f}" for row in rows for f in row["faults"]]
    return [
        "## Upgrades",
        "",
        command("upgrades", found),
        "",
        f"Databases of every earlier revision on {' and '.join(places)}, made by the migrations "
        "up to "
        "it and filled with records, a model, its draws, comparison, bounds and zones; brought "
        "up to "
        "date by one `db upgrade` and by two at once, and held against what was there, column by "
        "column.",
        "",
        *table(("revision", "rows", "upgrades", "with a difference"), lines),
        *listed(faults, "Every row is there as it was."),
    ]
