"""Errors that are stated too small are named, or said not to be told from natural scatter."""

from __future__ import annotations

import pytest

from avahazard.criticism.diagnosis.diagnose import diagnose
from avahazard.inference.model.specification import Specification
from tests.inference.misstated import misstated


@pytest.mark.slow
def test_errors_of_the_records_three_times_as_stated_are_named() -> None:
    found = diagnose(misstated(3.0, 1.0, 31, 250), Specification(), {}, n_worlds=39)
    assert (found.verdict, found.missing) == ("missing-effect", ("record-error",))


@pytest.mark.slow
def test_errors_of_the_volumes_do_not_pass_for_scatter() -> None:
    found = diagnose(misstated(1.0, 2.5, 31, 250), Specification(), {}, n_worlds=39)
    assert found.missing[0] == "volume-error"
    # Scatter that grows with volume looks alike: it may be said, never alone.
    assert set(found.missing) <= {"volume-error", "volume-scatter"}
