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
REQUESTS = """
## Requests { #api-requests }

`calibrate`, `diagnose`, `hazard`, `zones`, `volumes` and `report` take the fields of their request
by keyword: `model.hazard(return_periods=[30, 100])`.
"""
RESULTS = """
## Results { #api-results }

Each is a frozen dataclass; its fields are the keys of the [JSON](results.md), its methods those of
`Result`. `Rows` is a tuple of them with `.to_frame()`.
"""


def api_page() -> str:
    """Return the page: the objects of the API, what they are asked, and every result."""
    parts = [HEAD]
    for name in ("open_region", "Region", "Model"):
        anchor = name.lower().replace("_", "-")
        parts.append(f"\n## {anchor} {{ #api-{anchor} }}\n\n::: avahazard.api.{name}\n")
    parts.append(REQUESTS)
    parts += [f"::: avahazard.workflow.requests.{name}\n" for name in classes("workflow/requests")]
    parts.append(RESULTS)
    for file in sorted((PACKAGE / "results").glob("[a-z]*.py")):
        names = classes(f"results/{file.stem}")
        parts += [f"::: avahazard.results.{file.stem}.{name}\n" for name in names]
    return "\n".join(parts)


def classes(module: str) -> list[str]:
    """Return the names of a module's classes, in its order."""
    body = ast.parse((PACKAGE / f"{module}.py").read_text(encoding="utf-8")).body
    return [c.name for c in body if isinstance(c, ast.ClassDef)]
