"""docs/trust.md out of what the parts of `make trust` counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

Found = dict[str, Any]

HEAD = """\
# Faults, many users, upgrades, bad input

What is lost when the program is killed, the power fails or the disk is full; what many users at
once do to one another; what an upgrade keeps; what garbage does. Each table is written by the run
that stands above it; `make trust` runs them all in full, `make test` a short version of each.
"""


def page(found: Found) -> str:
    """The page of all parts that have been run."""
    parts: dict[str, Callable[[Found], list[str]]] = {
        "kills": _kills,
        "power": _power,
        "disks": _disks,
        "users": _users,
        "upgrades": _upgrades,
        "mutants": _mutants,
        "degenerate": _degenerate,
    }
    lines = [HEAD]
    for name, write in parts.items():
        if name in found:
            lines += write(found[name])
    if missing := [name for name in parts if name not in found]:
        lines.append(f"Not run yet: {', '.join(missing)}.")
    return "\n".join(lines).rstrip() + "\n"


def _command(part: str, found: Found, *options: str) -> str:
    given = "".join(f" --{name} {found['amounts'][name]:g}" for name in (*options, "seed"))
    return f"`.venv/bin/python benchmarks/trust.py {part}{given}`"


def _table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    ruler = ["---", *("--:" for _ in head[1:])]
    lines = [head, ruler, *([_cell(v) for v in row] for row in rows)]
    return [*("| " + " | ".join(line) + " |" for line in lines), ""]


def _cell(value: object) -> str:
    return f"{value:,}" if isinstance(value, int) else str(value)


def _faults(faults: Sequence[str], none: str) -> list[str]:
    if not faults:
        return [none, ""]
    shown = [f"- `{fault.replace('`', chr(39))}`".replace("\n", " ") for fault in faults]
    return [f"**{len(faults)} at fault:**", "", *shown, ""]


def _kills(found: Found) -> list[str]:
    rows = found["rows"]
    total = sum(row["kills"] for row in rows)
    places = list(dict.fromkeys(row["place"] for row in rows))
    jobs = list(dict.fromkeys(row["job"] for row in rows))
    table = []
    for job in jobs:
        mine = [row for row in rows if row["job"] == job]
        table.append([f"`{job}`", *(sum(row.get(k, 0) for row in mine) for k in STOOD)])
    return [
        "## kill -9",
        "",
        _command("kills", found, "kills"),
        "",
        f"{total} kills on {' and '.join(places)}, half of those on files within 50 ms of the "
        "first "
        "write, the others at any moment. After each: the rows are those of before, those of the "
        "command, or (bounds, path by path; the steps of `run`) some of the latter; records and "
        "models are whole; what had been confirmed is there; `db check --full` finds nothing; the "
        "same command, run again, ends as if nothing had happened; no file is half written.",
        "",
        *_table(("command", "kills", "stood as before", "in between", "as after"), table),
        *_faults(
            found["faults"], "Nothing was lost, half stored or damaged; no command was refused."
        ),
    ]


STOOD = ("kills", "before", "between", "after")


def _power(found: Found) -> list[str]:
    title = ["## Power cuts", "", _command("power", found, "cuts"), ""]
    if "skipped" in found:
        return [*title, f"Not run: {found['skipped']}.", ""]
    table = [
        (
            f"{row['synchronous']}{', log held open' if row['holder'] == 'held' else ''}",
            row["n_cuts"],
            row["n_confirmed"],
            row["lost"],
            row["partial"],
            row["damaged"],
        )
        for row in found["rows"]
    ]
    return [
        *title,
        "A library that is loaded before the program's own logs every write, sync, rename and "
        "removal "
        "of four imports and a calibration on SQLite. A cut falls at a random place of that log: "
        "what "
        "was synced is on the disk; of the rest none, all, or a random part, torn at 512 bytes. "
        "The "
        "program syncs in full (`synchronous = FULL`); the rows with less show that the study sees "
        "losses. PostgreSQL's own log is not studied.",
        "",
        *_table(("sync", "cuts", "confirmed", "lost", "in part", "damaged"), table),
    ]


def _disks(found: Found) -> list[str]:
    table = [(row["fault"], row["commands"], row["told"]) for row in found["rows"]]
    missing = "" if found["mounted"] else " Disks of one's own could not be mounted here."
    return [
        "## Disks and clocks",
        "",
        _command("disks", found, "sizes"),
        "",
        "The writing commands on a disk (in memory, of its own) that fills at a random place, on a "
        "read-only one, in a folder that is taken away meanwhile, and by a clock that jumps ten "
        "years "
        "to and fro at every third reading. Each ended well, or with one message and its remedy; "
        "the "
        f"database was whole, and the same command ended well afterwards.{missing}",
        "",
        *_table(("fault", "commands", "ended by a message"), table),
        *_faults(
            found["faults"], "No traceback, no message without a remedy, nothing half stored."
        ),
    ]


def _users(found: Found) -> list[str]:
    table = []
    for row in found["rows"]:
        turns = ", ".join(f"{n:,} {role}" for role, n in row["turns"].items())
        table.append(
            (row["place"], row["users"], turns, row["rows"], row["lost"], len(row["faults"]))
        )
    faults = [fault for row in found["rows"] for fault in row["faults"]]
    return [
        "## Many users",
        "",
        _command("users", found, "seconds", "rows"),
        "",
        f"Eight processes for {found['seconds']:g} s (imports, updates, calibrations, readers), "
        "then six "
        f"imports of {found['rows_of_import']:,} events each at once. Readers check that they see "
        "whole imports only, and no fewer than before.",
        "",
        *_table(("database", "users", "turns", "confirmed rows", "lost", "refused"), table),
        *_faults(faults, "Nobody was refused."),
    ]


def _upgrades(found: Found) -> list[str]:
    rows = found["rows"]
    places = list(dict.fromkeys(row["place"] for row in rows))
    revisions = list(dict.fromkeys(row["revision"] for row in rows))
    table = []
    for revision in revisions:
        mine = [row for row in rows if row["revision"] == revision]
        table.append(
            (revision, mine[0]["n_rows"], len(mine), sum(bool(row["faults"]) for row in mine))
        )
    faults = [f"{row['place']}, {row['revision']}: {f}" for row in rows for f in row["faults"]]
    return [
        "## Upgrades",
        "",
        _command("upgrades", found),
        "",
        f"Databases of every earlier revision on {' and '.join(places)}, made by the migrations "
        "up to "
        "it and filled with records, a model, its draws, comparison, bounds and zones; brought "
        "up to "
        "date by one `db upgrade` and by two at once, and held against what was there, column by "
        "column.",
        "",
        *_table(("revision", "rows", "upgrades", "with a difference"), table),
        *_faults(faults, "Every row is there as it was."),
    ]


def _mutants(found: Found) -> list[str]:
    table = [
        (row["form"], row["n_mutants"], row["accepted"], row["refused"]) for row in found["rows"]
    ]
    total = sum(row["n_mutants"] for row in found["rows"])
    return [
        "## Bad input",
        "",
        _command("mutants", found, "mutants", "chains"),
        "",
        f"{total:,} mutants of right files: cells, rows, columns, headings, words and bytes "
        "changed, "
        "doubled, cut. Each is accepted or refused with a message; anything else is at fault.",
        "",
        *_table(("form", "mutants", "accepted", "refused"), table),
        *_faults(found["faults"], "No traceback, and no reader that hangs."),
        f"{found['chains']} of the accepted went through the chain: import, calibrate, compare, "
        "hazard, "
        f"zones, fit, friction, ladder, export. {found['done']:,} commands succeeded, "
        f"{found['refused']:,} were refused with a message. A NaN in a result, or a calibration "
        "that "
        "calls itself converged on what is not finite or without spread, is at fault.",
        "",
        *_faults(found["chain_faults"], "None was."),
    ]


def _degenerate(found: Found) -> list[str]:
    table = [(row["set"], row["done"], row["refused"]) for row in found["rows"]]
    return [
        "## Records that tell next to nothing",
        "",
        _command("degenerate", found),
        "",
        "`fit`, `friction`, `volumes`, `alpha-beta`, `calibrate` by every method and law, "
        "`compare`, "
        "`diagnose`, `hazard`, `zones`, `model`, `ladder` on each set.",
        "",
        *_table(("records", "commands that succeeded", "refused with a message"), table),
        *_faults(found["faults"], "No traceback, no NaN."),
    ]
