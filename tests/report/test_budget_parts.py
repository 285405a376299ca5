"""Sources of error in the report: each has words in every language, and a colour of its own."""

from __future__ import annotations

from dataclasses import replace

import pytest

from avahazard.cli.model_tables import SOURCES as OF_TABLE
from avahazard.criticism.scoring.error_budget import SOURCES, UNEXPLAINED
from avahazard.report.budget_parts import COLORS, bars, part_words, parts_in_order
from avahazard.report.language import LANGUAGES, language_of
from avahazard.results.base import Rows
from avahazard.results.comparison import BudgetPart
from tests.results.samples import COMPARISON

ALL = (*SOURCES, UNEXPLAINED)


def test_every_source_is_told_everywhere() -> None:
    assert set(OF_TABLE) == set(COLORS) == set(ALL)
    for code in LANGUAGES:
        words = {part_words(source, language_of(code)) for source in ALL}
        assert len(words) == len(ALL), code
    assert part_words("release", language_of("de")) == "Fehler der Anrisse"


@pytest.mark.parametrize("with_release", [True, False])
def test_a_release_without_an_error_has_no_bar(with_release: bool) -> None:
    parts = [BudgetPart(s, 5.0) for s in ALL if s != "release" or with_release]
    found = bars(["m"], {"m": replace(COMPARISON, budget=Rows(parts))})
    assert ("release" in parts_in_order(found)) is with_release
    assert list(parts_in_order(found))[-1] == UNEXPLAINED
