"""Results of earlier runs, a JSON document a line: what a benchmark goes on from."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def finished(file: Path) -> list[dict[str, Any]]:
    """The lines of `file`, none where there is no such file yet."""
    if not file.exists():
        return []
    return [json.loads(text) for text in file.read_text(encoding="utf-8").splitlines()]
