"""The page as text: whole, harmless, and always the same."""

from __future__ import annotations

import base64
import hashlib
import html as markup
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import plotly.graph_objects as go
import pytest
from markupsafe import Markup

from avahazard.notes import Note
from avahazard.report.html.content import ReportContent
from avahazard.report.html.page import kept_together, render
from tests.report.html.pages import section_words
from tests.report.html.world import EVENT, NAMES
from tests.results.samples import NOT_COMPARED


class Reader(HTMLParser):
    """Elements with their attributes, and the text of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self.elements and self.elements[-1][0] == "script" and self.cdata_elem:
            self.scripts[-1] += data


@pytest.fixture(scope="module")
def reader(html: str) -> Reader:
    """Give the parsed page."""
    return Reader(html)


def test_the_page_states_its_language_and_title(reader: Reader) -> None:
    assert ("html", {"lang": "en"}) in reader.elements
    assert "title" in [tag for tag, _ in reader.elements]


def test_nothing_points_outside(reader: Reader) -> None:
    asking = {"src", "href", "srcset", "poster", "data", "action"}
    targets = [value for _, a in reader.elements for key, value in a.items() if key in asking]
    assert targets
    assert [t for t in targets if not t or not t.startswith(("#", "data:"))] == []


def test_links_lead_to_parts_of_the_page(reader: Reader) -> None:
    known = {a["id"] for _, a in reader.elements if "id" in a}
    links = {a["href"] for tag, a in reader.elements if tag == "a"}
    assert {link[1:] for link in links if link} <= known


def test_only_the_reports_own_script_may_run(reader: Reader) -> None:
    (policy,) = [
        a["content"] for _, a in reader.elements if a.get("http-equiv") == "Content-Security-Policy"
    ]
    kinds = [a.get("type") for tag, a in reader.elements if tag == "script"]
    assert kinds.count(None) == 1
    assert set(kinds) == {None, "application/json"}
    code = reader.scripts[kinds.index(None)]
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    assert policy is not None
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    handlers = [key for _, a in reader.elements for key in a if key.startswith("on")]
    assert handlers == []


def test_names_of_users_are_words(html: str) -> None:
    for name in (*NAMES.values(), EVENT, "covariate:<b>wind</b>"):
        assert name not in html or "<" not in name
    for name in NAMES.values():
        assert markup.escape(name).replace("&quot;", "&#34;").replace("&#x27;", "&#39;") in html


def test_figures_are_what_plotly_takes(reader: Reader) -> None:
    figures = [json.loads(text) for text in reader.scripts if text.startswith('{"data"')]
    assert len(figures) >= 14
    for figure in figures:
        assert figure["data"]
        go.Figure(figure["data"], figure["layout"])


def test_figures_have_words(reader: Reader) -> None:
    drawings = [a for _, a in reader.elements if "data-figure" in a]
    assert all(a["role"] == "img" and a["aria-label"] for a in drawings)
    keys = [a["data-figure"] for a in drawings]
    assert len(set(keys)) == len(keys)
    assert {"record", "ladder", "friction", "density", "posterior-1", "posterior-joint",
            "predicted-elevation", "effects", "path-1", "path-2", "path-3"} < set(keys)  # fmt: skip
    assert len([key for key in keys if key and key.startswith("map-")]) == 2


def test_the_size_of_a_region_stays_below_10_mb(content: ReportContent, html: str) -> None:
    assert len(html.encode()) < 6e6
    rough = np.random.default_rng(0).normal(1500.0, 30.0, (200, 200)).cumsum(axis=0) * 1e-2
    (mapped,) = (v for v in content.paths if v.plan is not None and v.plan.ground is not None)
    assert mapped.plan is not None
    assert mapped.plan.ground is not None
    ground = replace(mapped.plan.ground, elevation_m=rough.astype(np.float32))
    whole = replace(mapped, plan=replace(mapped.plan, ground=ground))
    region = replace(content, paths=(*content.paths, *(whole,) * 27))
    assert len(render(region).encode()) < 10e6


def test_the_same_content_gives_the_same_page(content: ReportContent, html: str) -> None:
    assert render(content) == html


def test_what_is_missing_is_said(content: ReportContent) -> None:
    bare = replace(
        content,
        comparison=None,
        diagnosis=None,
        rows=(),
        friction=None,
        densities=(),
        ladder=[replace(NOT_COMPARED, model="m")],
        paths=tuple(replace(v, rows=(), speeds=(), zones=None, plan=None) for v in content.paths),
        summaries=(),
        lacking={"rows": Note("no_bounds", model="m"),
                 "diagnosis": Note("not_diagnosed", model="m")},
    )  # fmt: skip
    text = render(bare)
    for lack in ("No bounds were computed.", "was not diagnosed for missing effects."):
        assert lack in text
    assert not re.search("avahazard (hazard|diagnose)", text)
    assert not re.search(r"\bNone\b", re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL))


def test_words_under_a_figure_count_what_is_not_in_it(content: ReportContent) -> None:
    more = replace(content, ladder=[*content.ladder, NOT_COMPARED])
    assert "Left out: 1 model never compared." in render(more)


def test_how_it_was_made_names_seed_versions_and_fingerprint(content: ReportContent) -> None:
    text = section_words(replace(content, effect_sha256="ab" * 32), "made")
    assert f"fingerprint of the records (SHA-256) {content.model.data_fingerprint}" in text
    assert f"version of avahazard {content.versions['avahazard']}" in text
    assert " seed 0 " in text
    assert "ab" * 32 in text


def test_the_brief_needs_no_script(content: ReportContent) -> None:
    text = render(replace(content, brief=True))
    assert len(text) < 60_000
    assert 'id="brief"' in text
    assert 'id="made"' not in text
    assert "<script>" not in text


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("5 m of 90 %", "5~m of 90~%"),
        ("up to 26%, 3 kPa", "up to 26~%, 3~kPa"),
        ("on 1950-02-13 3 models", "on 1950_02_13 3 models"),
        ("« a » : 3 ; non", "«~a~»~: 3~; non"),
        (Markup("<b>5 m</b>"), "<b>5 m</b>"),
    ],
)
def test_a_number_stays_with_its_unit_and_a_date_on_one_line(text: str, kept: str) -> None:
    assert kept_together(text) == kept.replace("~", "\u00a0").replace("_", "\u2011")
