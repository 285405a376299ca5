"""Faults, many users, upgrades, bad input and changes of the code; writes docs/trust.md.

make trust                                    all of it but guided, hours long
… benchmarks/trust.py power users             these parts; the page keeps what the others found
… benchmarks/trust.py kills --kills 60        fewer; kills by another --seed are added to the page
… benchmarks/trust.py kills --only import     kills of one command
… benchmarks/trust.py guided                  needs atheris (benchmarks/trust/guided.py)

PostgreSQL takes part where AVAHAZARD_TEST_POSTGRES names a server on which databases may be made;
for power cuts a server of their own is started, where one is installed.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from dataclasses import asdict, fields
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.trust.amounts import Amounts  # noqa: E402
from benchmarks.trust.page import page  # noqa: E402
from benchmarks.trust.parts import ASKED, PARTS, added  # noqa: E402

FOUND = HERE / "trust.json"
PAGE = HERE.parent / "docs" / "trust.md"


def main() -> None:
    """Do the parts that are named, keep what they found, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    for one in fields(Amounts):
        parser.add_argument(f"--{one.name}", type=type(one.default), default=one.default)
    given = vars(parser.parse_args())
    names = given.pop("parts") or [name for name in PARTS if name not in ASKED]
    if unknown := set(names) - set(PARTS):
        parser.error(f"no part is called {', '.join(unknown)}; there are {', '.join(PARTS)}")
    amounts = Amounts(**given)
    for name in names:
        began = time.monotonic()
        with tempfile.TemporaryDirectory(prefix="trust-") as folder:
            result = PARTS[name](amounts, Path(folder), lambda text: print(text, flush=True))
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
        # Read again: another part may have been run beside this one.
        found = json.loads(FOUND.read_text(encoding="utf-8")) if FOUND.exists() else {}
        found[name] = added(name, found.get(name), {"amounts": asdict(amounts), **result})
        FOUND.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        PAGE.write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    main()
