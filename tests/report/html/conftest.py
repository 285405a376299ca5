"""The report of the small dataset, gathered and rendered once."""

from __future__ import annotations

from pathlib import Path

import pytest

from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import render
from avahazard.workflow.report import gather
from avahazard.workflow.requests import ReportRequest
from tests.few_draws import few_draws
from tests.once import made_once
from tests.report.html.world import make_loop_database


@pytest.fixture(scope="session")
def content(report_database: str) -> ReportContent:
    """Give what the report of `m` is made of."""
    with few_draws():
        return gather(report_database, "m", ReportRequest())


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


@pytest.fixture(scope="session")
def loop_content(tmp_path_factory: pytest.TempPathFactory) -> ReportContent:
    """Give what the report of a child of a ladder of two models is made of."""
    database = made_once(tmp_path_factory, "loop", make_loop_database) / "loop.db"
    with few_draws():
        return gather(str(database), "child", ReportRequest())


@pytest.fixture(scope="session")
def loop_file(loop_content: ReportContent, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give that report as a file."""
    file = tmp_path_factory.mktemp("html") / "loop.html"
    file.write_text(render(loop_content), encoding="utf-8")
    return file
