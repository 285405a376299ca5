"""Faults, many users, upgrades and bad input; writes the tables of docs/trust.md.

make trust                                          all of it, hours long
… -m benchmarks.trust power users                   these parts; the others stay as they were found
… -m benchmarks.trust kills --kills 60 --seed 16    kills by another seed are added to the page
… -m benchmarks.trust kills --only import           kills of one command

PostgreSQL takes part where AVAHAZARD_TEST_POSTGRES names a server on which databases may be made;
for power cuts a server of their own is started, where one is installed.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from benchmarks.study import DOCS, HERE, Line, keep, lines, write_parts
from benchmarks.trust import answers, disks, inputs, kills, power, upgrades, users

FOUND = HERE / "trust.jsonl"
PARTS = {
    "kills": (kills.kills, ("kills", "seed", "only")),
    "power": (power.power, ("cuts", "seed")),
    "disks": (disks.disks, ("sizes", "seed")),
    "users": (users.users, ("seconds", "rows")),
    "upgrades": (upgrades.upgrades, ()),
    "mutants": (inputs.mutants, ("mutants", "chains", "seed")),
    "degenerate": (answers.degenerate, ()),
}
"""Each part, and the options that it has."""


def main() -> None:
    """Do the parts that are named, keep what they found, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    for name, amount in (
        ("kills", 300), ("cuts", 500), ("sizes", 4), ("seconds", 60.0), ("rows", 50_000),
        ("mutants", 20_000), ("chains", 200), ("seed", 15), ("only", ""),
    ):  # fmt: skip
        parser.add_argument(f"--{name}", type=type(amount), default=amount)
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"no part is called {', '.join(unknown)}; there are {', '.join(PARTS)}")
    for name in given.parts or PARTS:
        work, options = PARTS[name]
        with tempfile.TemporaryDirectory(prefix="trust-") as folder:
            result = work(given, Path(folder))
        words = [f"--{k} {v!r}" if k == "only" else f"--{k} {v:g}"
                 for k in options if (v := getattr(given, k)) != ""]  # fmt: skip
        # More moments of the same commands count too: kills have a line for each seed.
        kept = f"kills {given.seed}" if name == "kills" else name
        keep(FOUND, {"name": kept, "options": " ".join(words), **result})
        write_parts(DOCS / "trust.md", parts(lines(FOUND)))


def parts(found: list[Line]) -> dict[str, str]:
    """The parts of the page: the command of each, and its tables."""
    pages = {"power": power, "disks": disks, "users": users, "upgrades": upgrades,
             "mutants": inputs, "degenerate": answers}  # fmt: skip
    made = {line["name"]: f"{_command(line)}{pages[line['name']].page(line)}"
            for line in found if line["name"] in pages}  # fmt: skip
    if runs := [line for line in found if line["name"].startswith("kills")]:
        made["kills"] = "".join(map(_command, runs)) + kills.page(runs)
    return made


def _command(line: Line) -> str:
    words = f"{line['name'].split()[0]} {line['options']}".strip()
    return f"`.venv/bin/python -m benchmarks.trust {words}`\n\n"


if __name__ == "__main__":
    main()
