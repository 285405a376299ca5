"""The list of packages in pyproject.toml against the tree."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_every_package_of_the_tree_is_installed() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    found = {
        ".".join(init.parent.relative_to(ROOT).parts)
        for init in (ROOT / "avahazard").rglob("__init__.py")
    }
    found |= {"avahazard.data", "avahazard.migrations", "avahazard.migrations.versions"}
    assert sorted(listed) == sorted(found)


def test_migrations_and_data_are_found_as_parts_of_the_package() -> None:
    assert (files("avahazard.migrations") / "env.py").is_file()
    assert files("avahazard.data").is_dir()
