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


def guided(found: Found) -> list[str]:
    names = ("n_mutants", "accepted", "refused", "kept", "first", "last")
    lines = [(row["form"], *(row.get(name, "") for name in names)) for row in found["rows"]]
    total = sum(row.get("n_mutants", 0) for row in found["rows"])
    imported = sum(row.get("imported", 0) for row in found["rows"])
    run = command("guided", found, "mutants", "chains").strip("`")
    return [
        "### Guided by the branches that they reach",
        "",
        f"`PYTHONPATH=FOLDER {run}`",
        "",
        "(FOLDER: `pip install --no-deps --target FOLDER atheris==3.0.0`)",
        "",
        f"{total:,} inputs of the same forms, which a fuzzer (atheris on libFuzzer) makes of those "
        "before that "
        "reached a branch, or a comparison, of the readers that none had reached: by the changes "
        "of above, by words that "
        "stand in the readers' code, and by its own. `reached first` is what the right file "
        "reaches, `last` what all do.",
        "",
        *table(("form", "inputs", "accepted", "refused", "kept", "reached first", "last"), lines),
        *listed(found["faults"], "No traceback, and no reader that hangs."),
        f"{imported} of the tables were imported in earnest, and again. What is refused must "
        "leave every row as it was, what is accepted must change nothing the second time.",
        "",
        *listed(found["import_faults"], "So it was."),
        f"{found['chains']} of the accepted went through the chain of above with `diagnose`: "
        f"{found['done']:,} commands "
        f"succeeded, {found['refused']:,} were refused with a message.",
        "",
        *listed(found["chain_faults"], "None was at fault."),
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
