"""The Python API: the use cases that the commands call."""

from __future__ import annotations

import re
from pathlib import Path

from avahazard.cli.main import COMMANDS

FOLDER = Path(__file__).resolve().parents[2] / "avahazard" / "cli" / "commands"
IMPORT = re.compile(r"from (avahazard\.workflow\.\w+) import \(?([\w, \n]+)")

HEAD = """# Python API

Each command calls one function of `avahazard.workflow` and prints the document that it returns, so
a script can do whatever the command line does:

```python
from pathlib import Path

from avahazard.workflow.calibrate import calibrate
from avahazard.workflow.database import init_database
from avahazard.workflow.import_files import import_files
from avahazard.workflow.synth import synthesise

synthesise(Path("made-up"), n_events=60, n_paths=3)
init_database("script.db")
import_files("script.db", ["made-up"])
document = calibrate("script.db", "first", chains=2, draws=200)
print(document["parameters"]["a"]["mean"])
```

`database` is a file path or an SQLAlchemy URL. What the data do not allow raises
`avahazard.records.errors.AvahazardError`, whose `message` and `hint` the command line prints.
`report(what, done, total)` is called as long work goes on.
"""


def api_page() -> str:
    """Return the page: the use cases under the commands that call them."""
    parts, seen = [HEAD], set()
    for entry in COMMANDS:
        source = (FOLDER / f"{entry.module}.py").read_text(encoding="utf-8")
        names = [
            f"{module}.{name.split(' as ')[0].strip()}"
            for module, listed in IMPORT.findall(source)
            for name in listed.split(",")
            if name.strip()
        ]
        new = [name for name in dict.fromkeys(names) if name not in seen]
        seen.update(new)
        if new:
            parts.append(f"\n## {entry.name} {{ #api-{entry.name} }}\n")
            parts += [f"::: {name}\n" for name in new]
    return "\n".join(parts)
