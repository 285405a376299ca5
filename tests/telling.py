"""Whether words tell a fact, however they put it."""

from __future__ import annotations

import re


def untold(text: str, *facts: object) -> list[str]:
    """Return the facts (names, numbers, key words) that do not stand in `text` as whole words."""
    plain = " ".join(text.split())
    return [
        str(fact)
        for fact in facts
        if not re.search(rf"(?<![\w.]){re.escape(str(fact))}(?!\w|\.\d)", plain)
    ]
