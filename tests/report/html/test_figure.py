"""Figures as JSON inside the page."""

from __future__ import annotations

import json

import numpy as np
import pytest

from avahazard.report.html.figure import Figure, label, rounded, script_json


def test_json_comes_back_and_cannot_end_the_element() -> None:
    value = {"text": "</script><!-- & \u2028 é", "x": np.array([1.0, np.nan]), "n": np.int64(3)}
    text = script_json(value, 5)
    assert not set("<>&\u2028") & set(text)
    assert json.loads(text) == {"text": value["text"], "x": [1, None], "n": 3}


@pytest.mark.parametrize(
    ("value", "short"),
    [(123456.789, 123460), (0.000123456, 0.00012346), (-1.0, -1), (0.0, 0.0), (7, 7), ("a", "a")],
)
def test_numbers_keep_the_digits_that_a_screen_shows(value: object, short: object) -> None:
    assert rounded(value, 5) == short
    assert rounded({"a": [value]}, 5) == {"a": [short]}


def test_a_figure_keeps_its_own_digits() -> None:
    data = [{"x": [380123.456789]}]
    plain = Figure("k", "t", data, {"height": 300})
    fine = Figure("k", "t", data, {"height": 300}, digits=9)
    assert json.loads(plain.json)["data"][0]["x"] == [380120]
    assert json.loads(fine.json)["data"][0]["x"] == [380123.457]
    assert plain.height == 300


def test_labels_hold_no_mark_that_plotly_reads() -> None:
    assert label("<b>a</b> & $x$") == "&lt;b&gt;a&lt;/b&gt; &amp; &#36;x&#36;"
