"""The Python API: regions, models, and the results that they return."""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "avahazard"

HEAD = """# Python API

```python
import avahazard as av

region = av.open("avahazard.db")            # or av.Region.from_files("my-records")
base = region.calibrate("base", law="exponential")
base.compare().scores                       # a frozen dataclass; .to_frame() gives pandas
base.diagnose().candidates.to_frame()
child = base.add("forest-drag", name="forest")
region.ladder().plot()                      # a picture in a notebook, or a file
child.hazard(return_periods=[30, 100]).rows.to_frame()
```

What the data do not allow raises `av.AvahazardError`, whose `message` and `hint` the command line
prints. [The loop in a notebook](tutorial/notebook.md) goes through it.
"""
RESULTS = """
## Results { #api-results }

Each is a frozen dataclass; its fields are the keys of the [JSON](results.md), its methods those of
`Result`. `Rows` is a tuple of them with `.to_frame()`.
"""


def api_page() -> str:
    """Return the page: the objects of the API, then every result."""
    parts = [HEAD]
    for name in ("region.open_region", "region.Region", "model.Model"):
        anchor = name.rpartition(".")[2].lower().replace("_", "-")
        parts.append(f"\n## {anchor} {{ #api-{anchor} }}\n\n::: avahazard.api.{name}\n")
    parts.append(RESULTS)
    for file in sorted((PACKAGE / "results").glob("[a-z]*.py")):
        body = ast.parse(file.read_text(encoding="utf-8")).body
        names = [c.name for c in body if isinstance(c, ast.ClassDef)]
        parts += [f"::: avahazard.results.{file.stem}.{name}\n" for name in names]
    return "\n".join(parts)
