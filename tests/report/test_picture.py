"""Pictures into files."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.records.errors import AvahazardError
from avahazard.report.picture import FORMATS, picture


@pytest.mark.parametrize("suffix", FORMATS)
def test_every_format_is_written(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"a{suffix.upper()}"
    with picture(file) as axes:
        axes.plot([0.0, 1.0])
    assert file.stat().st_size > 1000


def test_a_name_of_no_picture(tmp_path: Path) -> None:
    with pytest.raises(AvahazardError, match="not the name of a picture"), picture(tmp_path / "a"):
        pass
