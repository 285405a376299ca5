"""Results as plain values."""

from __future__ import annotations

import json

import numpy as np

from avahazard.results.plain import plain


def test_arrays_scalars_and_missing_numbers_become_plain() -> None:
    value = {
        "a": np.array([[1.5, np.nan]]),
        "b": (np.int64(3), np.bool_(True), float("inf")),
        7: None,
        "d": "text",
    }
    expected = {"a": [[1.5, None]], "b": [3, True, None], "7": None, "d": "text"}
    assert plain(value) == expected
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == expected
