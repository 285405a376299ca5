"""The report of the small world, gathered and rendered once."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.workflow.report import gather


@pytest.fixture(scope="session")
def content(report_database: str) -> ReportContent:
    """Give what the report of `m` is made of."""
    return gather(report_database, "m")


@pytest.fixture(scope="session")
def html(content: ReportContent) -> str:
    """Give the report as text."""
    return render(content)


@pytest.fixture(scope="session")
def report_file(html: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give the report as a file."""
    file = tmp_path_factory.mktemp("html") / "report.html"
    file.write_text(html, encoding="utf-8")
    return file
