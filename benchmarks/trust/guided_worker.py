"""One form before its reader, by inputs that a fuzzer makes for the branches that they reach.

`python -m benchmarks.trust.guided_worker FORM N SEED DATABASE FOLDER` with atheris (libFuzzer) at
hand. Kept inputs, each of which reached something new, are left in FOLDER/corpus, those that were
accepted in FOLDER/accepted, and what came of all in FOLDER/found.json.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

try:
    import atheris
except ImportError:  # it is in no lock: see benchmarks/trust/guided.py
    atheris = None

READERS = (
    "avahazard.records",
    "avahazard.gis",
    "avahazard.effects.own_file",
    "avahazard.hazard.zones.limits",
    "avahazard.hazard.zones.limits_file",
    "avahazard.workflow.project",
    "avahazard.workflow.import_files",
)
"""What is instrumented: branches and comparisons in these."""
PACKAGE = Path(__file__).resolve().parents[2] / "avahazard"
LONGER = 16
"""Inputs may be so many times as long as the right file: a changed workbook is not packed."""


def main() -> None:
    """Read N inputs of a form; the process ends with the last."""
    form, n, seed, database, folder = sys.argv[1:]
    if atheris is None:
        raise SystemExit("atheris is missing.")
    with atheris.instrument_imports(include=list(READERS), exclude=others()):
        from benchmarks.trust.guided_mutants import varied, words_of  # noqa: PLC0415
        from benchmarks.trust.readers import Read, read_one  # noqa: PLC0415
        from benchmarks.trust.sources import sources  # noqa: PLC0415
    inside = Path(folder)
    source = next(one for one in sources(inside.parent) if one.form == form)
    corpus, taken = inside / "corpus", inside / "accepted"
    corpus.mkdir()
    taken.mkdir()
    (corpus / "right").write_bytes(source.content)
    found, words, most = Read(form), words_of(READERS), int(n)

    def read(data: bytes) -> None:
        if found.n_mutants < most:
            n_faults = len(found.faults)
            if read_one(source, data, database, inside, found) and data != source.content:
                (taken / f"{found.n_mutants - 1:06d}").write_bytes(data)
            if len(found.faults) > n_faults:
                (inside / f"fault-{found.n_mutants - 1}").write_bytes(data)
        if found.n_mutants == most:  # the fuzzer ends the process by itself, soon
            (inside / "found.json").write_text(json.dumps({**asdict(found), "kept": []}))

    def mutate(data: bytes, longest: int, key: int) -> bytes:
        rng = np.random.default_rng(key)
        what = rng.random()
        if what < 0.1:
            return bytes(atheris.Mutate(data, longest))
        if what < 0.5:  # most that are kept are refused early: what goes further comes from here
            data = source.content
        return varied(source, data, words, rng)[:longest]

    options = (
        f"-runs={n}", f"-seed={seed}", f"-max_len={LONGER * len(source.content) + 4096}",
        "-len_control=0", "-timeout=0", "-handle_alrm=0", "-rss_limit_mb=6000",
        f"-artifact_prefix={inside}/",
    )  # fmt: skip
    atheris.Setup([sys.argv[0], *options, str(corpus)], read, custom_mutator=mutate)
    atheris.Fuzz()


def others() -> list[str]:
    """All modules of the package but the `READERS`, by name.

    atheris takes the whole package where one module of it is named, and numba compiles no kernel
    that is instrumented: readers that need one would be at fault.
    """
    files = (file.relative_to(PACKAGE.parent).with_suffix("") for file in PACKAGE.rglob("*.py"))
    names = {".".join(file.parts).removesuffix(".__init__") for file in files}
    inside = tuple(f"{name}." for name in READERS)
    return sorted(name for name in names if not f"{name}.".startswith(inside))


if __name__ == "__main__":
    main()
