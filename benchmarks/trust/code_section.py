"""Section of docs/trust.md: changes of the code that the tests see, and those that they do not."""

from __future__ import annotations

import json
from pathlib import Path

from benchmarks.trust.code_mutants import MOST_TEST_S
from benchmarks.trust.markdown import Found, command, table

READ = Path(__file__).with_name("survivors.json")
"""What reading the survivors said of each, by module, function and change."""
WANTED = 0.85


def code(found: Found) -> list[str]:
    rows = found["rows"]
    tried, killed = (sum(row[name] for row in rows) for name in ("tried", "killed"))
    lines = [
        (row["part"], row["changes"], row["tried"], row["killed"], row["too long"],
         f"{row['killed'] / max(row['tried'], 1):.0%}")
        for row in rows
    ]  # fmt: skip
    return [
        "## Changes of the code",
        "",
        command("code", found, "changes"),
        "",
        "The usual operators of mutation testing (other arithmetic, comparisons, logic, numbers + "
        "1, signs, branches, calls left out) make every small change of `physics/`, of the "
        "likelihood and of `hazard/`; words, types and messages of errors stay. Of these a sample, "
        "as dense in each module, is tried one by one on the tests under the mirrored folder that "
        "run the changed line, without those marked slow. Kernels are tried uncompiled, on the "
        f"tests of kernels by themselves, without those that then take over {MOST_TEST_S:g} s. A "
        "change is killed when a test fails, or takes far too long.",
        "",
        *table(("part", "changes", "tried", "killed", "of these by time", "share"), lines),
        f"In all {killed} of {tried} are killed: {killed / tried:.1%}; {WANTED:.0%} are asked.",
        "",
        *_survivors(found),
    ]


def _survivors(found: Found) -> list[str]:
    read = json.loads(READ.read_text(encoding="utf-8")) if READ.exists() else {}
    lines = []
    for one in found["survivors"]:
        said = read.get(name_of(one), "not read yet")
        place = one["place"].removeprefix("avahazard/")
        what = one["what"].replace("`", "'")
        lines.append(f"- `{place}` `{what}`: {said}")
    if not lines:
        return ["None survived.", ""]
    return ["Those that survived, each read:", "", *lines, ""]


def name_of(survivor: dict[str, str]) -> str:
    """The name of a survivor, which stays when lines move."""
    module = survivor["place"].partition(":")[0].removeprefix("avahazard/")
    return f"{module} {survivor['where']}: {survivor['what']}"
