"""Parts of the package that stand elsewhere in the tree; the wheel is tested with the packaging."""

from __future__ import annotations

from importlib.resources import files


def test_migrations_and_data_are_found_as_parts_of_the_package() -> None:
    assert (files("avahazard.migrations") / "env.py").is_file()
    assert files("avahazard.data").is_dir()
