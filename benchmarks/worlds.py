"""The loop on synthetic datasets with known truth, and its page from the results.

… benchmarks/worlds.py arms                        names of the arms, one a line
… benchmarks/worlds.py make ARM SEED FOLDER        a dataset beyond the catalogue, as CSV
… benchmarks/worlds.py beyond --seeds 1-2 -o FILE  the loop on these seeds of every arm
… benchmarks/worlds.py measuring --seeds 1-2 -o FILE  speeds as advised, and by a fixed plan
… benchmarks/worlds.py table FILE [--page PAGE]    its tables, printed or written into a page

All arms are gone through before the next seed; what FILE has is left out.  Seeds below 1000 are for
building; those from 5000 on are for the final measurement alone.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.study import lines, run_missing, write_parts  # noqa: E402
from benchmarks.worlds import beyond, catalogue, measuring, tables  # noqa: E402
from benchmarks.worlds.loop import judge as judge_loop  # noqa: E402


def arms() -> list[str]:
    """Names of all arms: effects, then nulls, those without speeds first."""
    plain = [*beyond.ARMS, *catalogue.ARMS]
    effects = [name for name in plain if not name.startswith("null")]
    nulls = [name for name in plain if name.startswith("null")]
    own = [name + beyond.SPEEDS for name in (*effects, *nulls) if name in beyond.ARMS]
    return [*effects, *nulls, *own]


def run(given: argparse.Namespace) -> None:
    """The loop, or the plans of measuring, on what has no line yet."""
    low, _, high = given.seeds.partition("-")
    asked = given.arms or [""]
    loop = given.command == "beyond"
    judge = judge_loop if loop else measuring.judge
    known = arms() if loop else measuring.ARMS
    chosen = [name for name in known if any(part in name for part in asked)]
    names = [f"{name} #{k}" for k in range(int(low), int(high or low) + 1) for name in chosen]
    given.output.parent.mkdir(parents=True, exist_ok=True)
    run_missing(given.output, [(name, name) for name in names], judge, minutes=given.minutes)


def main() -> None:
    """What the command line says."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("arms")
    make = commands.add_parser("make")
    make.add_argument(
        "arm",
        choices=[x for x in arms() if x.removesuffix(beyond.SPEEDS) in beyond.ARMS],
        metavar="ARM",
    )
    make.add_argument("seed", type=int)
    make.add_argument("folder", type=Path)
    for study in ("beyond", "measuring"):
        loop = commands.add_parser(study)
        loop.add_argument("--seeds", required=True, metavar="A-B")
        loop.add_argument(
            "--arms", nargs="+", metavar="PART", help="arms with one of these in their name"
        )
        loop.add_argument("--minutes", type=float, default=1e6, help="begin no dataset after that")
        loop.add_argument("-o", "--output", type=Path, required=True)
    table = commands.add_parser("table")
    table.add_argument("results", type=Path)
    table.add_argument("--page", type=Path)
    given = parser.parse_args()
    if given.command == "arms":
        print("\n".join(arms()))
    elif given.command == "make":
        beyond.make(given.arm, given.seed, given.folder)
    elif given.command in ("beyond", "measuring"):
        run(given)
    else:
        found = lines(given.results)
        parts = (measuring if "advised" in found[0] else tables).parts(found)
        if given.page:
            write_parts(given.page, parts)
        else:
            print("\n\n".join(parts.values()))


if __name__ == "__main__":
    main()
