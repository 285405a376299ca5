"""Section of docs/trust.md: changes of the code that the tests see, and those that they do not."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from benchmarks.trust.code_mutants import MOST_TEST_S
from benchmarks.trust.markdown import Found, command, table

READ = Path(__file__).with_name("survivors.json")
"""What reading the survivors said of each, by module, function and change."""
EQUIVALENT, UNREAD = "the same", "not read yet"
"""How what is said of a survivor begins that changes nothing a test could see, or is not read."""
WANTED = 0.85


def code(found: Found) -> list[str]:
    rows = found["rows"]
    read = json.loads(READ.read_text(encoding="utf-8")) if READ.exists() else {}
    said = [str(read.get(name_of(one), UNREAD)) for one in found["survivors"]]
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
        "run the changed line, and if these do not see it on the others that run it, without "
        f"those marked slow or over {MOST_TEST_S:g} s. Kernels are tried uncompiled, on the "
        "tests of kernels by themselves alone. A change is killed when a test fails, or takes far "
        "too long.",
        "",
        *table(("part", "changes", "tried", "killed", "of these by time", "share"), lines),
        f"In all {killed} of {tried} are killed: {killed / tried:.1%}. {_score(killed, said)} "
        f"{WANTED:.0%} are asked.",
        "",
        *_survivors(found["survivors"], said),
    ]


def _score(killed: int, said: Sequence[str]) -> str:
    """What counts, by what is `said` of each survivor: fixed before a sample is drawn."""
    if UNREAD in said:
        return "The survivors are not read yet."
    changing = killed + sum(not words.startswith(EQUIVALENT) for words in said)
    return (
        "The mutation score is the share of those that are not equivalent to the true code (Y. Jia "
        "and M. Harman, An analysis and survey of the development of mutation testing, 2011), here "
        f"by reading each survivor; one in doubt counts as not equivalent: {killed} of {changing}, "
        f"{killed / max(changing, 1):.1%};"
    )


def _survivors(survivors: Sequence[dict[str, str]], said: Sequence[str]) -> list[str]:
    lines = []
    for one, words in zip(survivors, said, strict=True):
        place = one["place"].removeprefix("avahazard/")
        what = one["what"].replace("`", "'")
        lines.append(f"- `{place}` `{what}`: {words}")
    if not lines:
        return ["None survived.", ""]
    return ["Those that survived, each read:", "", *lines, ""]


def name_of(survivor: dict[str, str]) -> str:
    """The name of a survivor, which stays when lines move."""
    module = survivor["place"].partition(":")[0].removeprefix("avahazard/")
    return f"{module} {survivor['where']}: {survivor['what']}"
