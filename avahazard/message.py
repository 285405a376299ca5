"""Sentences that people read: marked where they are composed, translated where they are shown."""

from __future__ import annotations

from collections.abc import Sequence


def message(text: str) -> str:
    """The text itself, with named places `{…}`: the catalogues of the report have it by this mark.

    Results keep the English sentence; `avahazard.report.language` finds it again by its places.
    """
    return text


def counted(n: int, thing: str, many: str = "") -> str:
    """A number of things in English: `1 event`, `3 events`."""
    return f"{n} {thing if n == 1 else many or thing + 's'}"


def named(names: Sequence[str]) -> str:
    """Names in a row, as a sentence has them: `a, b and c`."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"
