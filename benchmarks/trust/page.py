"""docs/trust.md out of what the parts of `make trust` counted."""

from __future__ import annotations

from collections.abc import Callable
from textwrap import fill

from benchmarks.trust import code_section, fault_sections, input_sections
from benchmarks.trust.markdown import Found

WIDTH = 104
VERBATIM = ("|", "`", "-", "#")
HEAD = """\
# Faults, many users, upgrades, bad input

What is lost when the program is killed, the power fails or the disk is full; what many users at
once do to one another; what an upgrade keeps; what garbage does; what the tests see of a wrong
line of code. Each table is written by the run that stands above it; `make trust` runs them all in
full (but for the guided inputs, which need a fuzzer), `make test` a short version of each.
"""


def page(found: Found) -> str:
    """The page of all parts that have been run, with a `note` on how, where one was written."""
    parts: dict[str, Callable[[Found], list[str]]] = {
        "kills": fault_sections.kills,
        "power": fault_sections.power,
        "disks": fault_sections.disks,
        "users": fault_sections.users,
        "upgrades": fault_sections.upgrades,
        "mutants": input_sections.mutants,
        "guided": input_sections.guided,
        "degenerate": input_sections.degenerate,
        "code": code_section.code,
    }
    lines = [HEAD]
    for name, write in parts.items():
        if name in found:
            lines += write(found[name])
            if note := found[name].get("note"):
                lines += [note, ""]
    if missing := [name for name in parts if name not in found]:
        lines.append(f"Not run yet: {', '.join(missing)}.")
    return "\n".join(map(_wrapped, lines)).rstrip() + "\n"


def _wrapped(line: str) -> str:
    return line if line.startswith(VERBATIM) or "\n" in line else fill(line, WIDTH)
