"""The page of the α-β runouts on real profiles is what the command gives."""

from __future__ import annotations

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_page_is_what_the_command_gives(shared_data: Path) -> None:
    spec = spec_from_file_location("alpha_beta_page", ROOT / "benchmarks" / "alpha_beta.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    written = (ROOT / "docs" / "alpha-beta.md").read_text(encoding="utf-8")
    assert module.page(shared_data / "tyrol-profiles") == written
