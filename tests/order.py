"""In which order the files of tests run, so that no worker waits for another."""

from __future__ import annotations

from collections import Counter

import pytest

COMPILES = "tests/docs/test_results.py"
"""Calls nearly every command, and so compiles nearly every kernel: one worker begins with it."""
NO_KERNELS = (
    "tests/test_packaging.py",
    "tests/test_kernels.py",
    "tests/docs/test_site.py",
    "tests/trust/test_mutants.py",
    "tests/store/",
    "tests/cli/test_help.py",
    "tests/cli/test_main.py",
    "tests/records/",
    "tests/gis/",
    "tests/report/test_catalogues.py",
    # Their calibrations are short where the other worker has compiled most by now.
    "tests/trust/test_kills.py",
    "tests/trust/test_forked.py",
    "tests/trust/test_users.py",
    "tests/trust/test_power.py",
    "tests/trust/test_upgrades.py",
)
"""Compile none of them, or few: what the other worker does meanwhile."""


def ordered(items: list[pytest.Item]) -> list[pytest.Item]:
    """The tests by file: first that which compiles, then those without kernels, then the rest.

    Of the rest those with few tests come first: a test of theirs takes long, and what runs last
    should be short.
    """
    count = Counter(file_of(item) for item in items)

    def place(item: pytest.Item) -> tuple[int, int, str]:
        file = file_of(item)
        if file == COMPILES:
            return 0, 0, file
        alone = [k for k, name in enumerate(NO_KERNELS) if file.startswith(name)]
        return (1, alone[0], file) if alone else (2, count[file], file)

    return sorted(items, key=place)


def file_of(item: pytest.Item) -> str:
    """The file that a test stands in."""
    return item.nodeid.split("::")[0]
