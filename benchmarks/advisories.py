"""The locked dependencies held against the advisories of pypa/advisory-database.

make lint                          every locked version was held, and none is affected
make advisories DATABASE=FOLDER    hold the locks against a clone of it (git, no network)

Kept in advisories.json is what came of it: the state of the database (commit, date), the versions
that were held, the advisories that affect one, and why such a one is borne, if it is. The
advisories themselves are not kept: a clone of the day on which a version is locked has more.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import yaml
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).resolve().parents[1]
LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-bench.lock")
KEPT = ROOT / "benchmarks" / "advisories.json"
DATABASE = "https://github.com/pypa/advisory-database"
PIN = re.compile(r"^([A-Za-z0-9][A-Za-z0-9._-]*)==([^\s;\\]+)", re.MULTILINE)
ENDS = ("fixed", "last_affected", "limit")
Advisory = Mapping[str, Any]


def main() -> int:
    """Hold the locks against a clone, or check that they were; status 1 where one is at fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--database", help="a clone of pypa/advisory-database, bare or not")
    given = parser.parse_args()
    locked = pins((ROOT / name).read_text(encoding="utf-8") for name in LOCKS)
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    if given.database:
        kept = held(locked, given.database, kept["borne"])
        KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    faults = faults_of(locked, kept)
    for fault in faults:
        print(fault, file=sys.stderr)
    age = (date.today() - date.fromisoformat(kept["date"])).days
    print(
        f"Advisories: {len(kept['held'])} locked versions held against {kept['advisories']} of "
        f"{kept['database']} as of {kept['date']}, {age} days ago: "
        f"{len(kept['affected'])} affected."
    )
    return 1 if faults else 0


def pins(locks: Iterable[str]) -> list[str]:
    """Every `name==version` of the texts of locks, by the names of the index, sorted."""
    found = (pin for text in locks for pin in PIN.findall(text))
    return sorted({f"{canonicalize_name(name)}=={version}" for name, version in found})


def faults_of(locked: Sequence[str], kept: Mapping[str, Any]) -> list[str]:
    """What stands against these pins: one that was not held, or is affected and not borne."""
    unheld = [
        f"{pin} was not held against the advisories: "
        f"make advisories DATABASE=<a clone of {DATABASE}>"
        for pin in sorted(set(locked) - set(kept["held"]))
    ]
    affected = [
        f"{one['pin']} is affected by {', '.join([one['id'], *one['aliases']])}; fixed in "
        f"{', '.join(one['fixed']) or 'no version'}. Lock another, or say under `borne` in "
        f"{KEPT.name} why it is borne."
        for one in kept["affected"]
        if one["pin"] in locked and one["id"] not in kept["borne"]
    ]
    return unheld + affected


def held(locked: Sequence[str], database: str, borne: Mapping[str, str]) -> dict[str, Any]:
    """What comes of holding these pins against the newest commit of a clone."""
    commit, day = _git(database, "log", "-1", "--format=%H %cs").split()
    names = {pin.partition("==")[0] for pin in locked}
    files = _git(database, "ls-tree", "-r", "--name-only", "HEAD", "vulns/").splitlines()
    selected = [f for f in files if canonicalize_name(f.split("/")[1]) in names]
    if not files:
        raise SystemExit(f"{database} holds no vulns/: it is no clone of {DATABASE}.")
    advisories = [yaml.safe_load(_git(database, "show", f"HEAD:{file}")) for file in selected]
    found = [
        {
            "pin": pin,
            "id": advisory["id"],
            "aliases": advisory.get("aliases", []),
            "fixed": fixed_in(advisory, pin),
        }
        for pin in locked
        for advisory in advisories
        if affects(advisory, pin)
    ]
    return {
        "database": DATABASE,
        "licence": "CC-BY-4.0",
        "commit": commit,
        "date": day,
        "advisories": len(advisories),
        "of_packages": len({canonicalize_name(f.split("/")[1]) for f in selected}),
        "affected": found,
        "borne": {one["id"]: borne[one["id"]] for one in found if one["id"] in borne},
        "held": list(locked),
    }


def affects(advisory: Advisory, pin: str) -> bool:
    """Whether an advisory is about this version: listed, or within a range (OSV's rule)."""
    name, _, text = pin.partition("==")
    version = Version(text)
    if "withdrawn" in advisory:
        return False
    for part in _parts(advisory, name):
        if version in (Version(v) for v in part.get("versions", ())):
            return True
        if any(_within(version, events) for events in _events(part)):
            return True
    return False


def fixed_in(advisory: Advisory, pin: str) -> list[str]:
    """The versions that an advisory names as corrected."""
    parts = _parts(advisory, pin.partition("==")[0])
    ends = [
        e["fixed"] for part in parts for events in _events(part) for e in events if "fixed" in e
    ]
    return sorted(set(map(str, ends)), key=Version)


def _parts(advisory: Advisory, name: str) -> list[Mapping[str, Any]]:
    """What an advisory says of a package, whose name may be written otherwise there."""
    return [
        part
        for part in advisory.get("affected", ())
        if canonicalize_name(part["package"]["name"]) == name
    ]


def _events(part: Mapping[str, Any]) -> list[list[Mapping[str, str]]]:
    return [r["events"] for r in part.get("ranges", ()) if r["type"] == "ECOSYSTEM"]


def _within(version: Version, events: Sequence[Mapping[str, str]]) -> bool:
    """Whether the last event up to a version opens the range; `last_affected` ends after it."""
    inside = False
    for event in sorted(events, key=_place):
        (kind, text), *_ = event.items()
        at = Version(str(text))
        if kind == "introduced":
            inside = inside or version >= at
        elif version > at if kind == "last_affected" else version >= at:
            inside = False
    return inside


def _place(event: Mapping[str, str]) -> tuple[Version, bool]:
    (kind, text), *_ = event.items()
    return Version(str(text)), kind in ENDS


def _git(database: str, *words: str) -> str:
    done = subprocess.run(
        ["git", "-C", database, *words], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise SystemExit(f"git {' '.join(words)} in {database}: {done.stderr.strip()}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
