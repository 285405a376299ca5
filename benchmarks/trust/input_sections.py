"""Sections of docs/trust.md: mutants of files, records that tell next to nothing."""

from __future__ import annotations

from benchmarks.trust.markdown import Found, command, listed, table


def mutants(found: Found) -> list[str]:
    lines = [
        (row["form"], row["n_mutants"], row["accepted"], row["refused"]) for row in found["rows"]
    ]
    total = sum(row["n_mutants"] for row in found["rows"])
    return [
        "## Bad input",
        "",
        command("mutants", found, "mutants", "chains"),
        "",
        f"{total:,} mutants of right files: cells, rows, columns, headings, words and bytes "
        "changed, "
        "doubled, cut. Each is accepted or refused with a message; anything else is at fault.",
        "",
        *table(("form", "mutants", "accepted", "refused"), lines),
        *listed(found["faults"], "No traceback, and no reader that hangs."),
        f"{found['chains']} of the accepted went through the chain: import, calibrate, compare, "
        "hazard, "
        f"zones, fit, friction, ladder, export. {found['done']:,} commands succeeded, "
        f"{found['refused']:,} were refused with a message. A NaN in a result, or a calibration "
        "that "
        "calls itself converged on what is not finite or without spread, is at fault.",
        "",
        *listed(found["chain_faults"], "None was."),
    ]


def degenerate(found: Found) -> list[str]:
    lines = [(row["set"], row["done"], row["refused"]) for row in found["rows"]]
    return [
        "## Records that tell next to nothing",
        "",
        command("degenerate", found),
        "",
        "On each set: `fit`, `friction`, `volumes`, `alpha-beta`, `calibrate` by every method and "
        "law, `compare`, `diagnose`, `hazard`, `zones`, `model`, `ladder`.",
        "",
        *table(("records", "commands that succeeded", "refused with a message"), lines),
        *listed(found["faults"], "No traceback, no NaN."),
    ]
