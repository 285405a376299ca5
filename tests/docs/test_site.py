"""The site: it builds without a warning, needs no network, and leaves nothing out."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest
from typer.main import get_command

import avahazard as av
from avahazard.cli.main import app
from avahazard.effects.catalogue import catalogue
from avahazard.results.base import Result
from tests.cli.test_help import ALL
from tests.report.html.chromium import chromium

KEYS = tuple(catalogue())

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    p.relative_to(ROOT / "docs")
    for p in (ROOT / "docs").rglob("*.md")
    if "_tools" not in p.parts  # no page, but part of one
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give the folder of the site, built anew."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


def sections(html: str) -> dict[str, str]:
    """The text of each section of a page (second headings), without marks, by its anchor."""
    parts = re.split(r'<h2 id="([^"]+)">', html)
    return {
        anchor: unescape(re.sub(r"<[^>]+>", "", text))
        for anchor, text in zip(parts[1::2], parts[2::2], strict=True)
    }


def test_the_output_of_every_command_is_explained(site: Path) -> None:
    documented = sections((site / "commands.html").read_text(encoding="utf-8"))
    for name in ALL:
        explained = documented[name.replace(" ", "-")].partition("Output:")[2]
        assert len(explained.split()) > 5, name


def test_every_command_and_every_option_is_documented(site: Path) -> None:
    documented = sections((site / "commands.html").read_text(encoding="utf-8"))
    leaves = {name.replace(" ", "-"): command for name, command in ALL.items()}
    for anchor, command in {"options-of-all-commands": get_command(app), **leaves}.items():
        text = documented[anchor]
        for parameter in command.params:
            is_option = parameter.param_type_name == "option"
            for name in parameter.opts if is_option else [parameter.metavar or parameter.name]:
                assert name in text, f"{anchor}: {name}"
            says = " ".join(parameter.help.replace("`", "").split())
            assert says in " ".join(text.split()), f"{anchor}: {parameter.name}"
        assert "For example:" in text or anchor == "options-of-all-commands"


def test_every_effect_is_documented(site: Path) -> None:
    documented = sections((site / "effects.html").read_text(encoding="utf-8"))
    made = {"covariatecolumn", "interactioncolumnother", "changepath", "scattercolumn", "pathpath"}
    assert {key.replace(":", "") for key in KEYS} | made == documented.keys()
    assert all("It needs:" in text for text in documented.values())


def test_every_public_name_is_in_the_api(site: Path) -> None:
    documented = sections((site / "api.html").read_text(encoding="utf-8"))
    assert documented.keys() == {
        *("api-open-region", "api-region", "api-model"),
        *("api-requests", "api-results"),
    }
    methods = [name for name in vars(av.Region) | vars(av.Model) if not name.startswith("_")]
    text = "".join(documented.values())
    assert [name for name in methods if name not in text] == []
    results = documented["api-results"]
    ours = [k for k in Result.__subclasses__() if k.__module__.startswith("avahazard.")]
    kinds = [kind.__name__ for kind in ours]
    assert len(kinds) > 40
    assert [name for name in kinds if name not in results] == []


def test_every_page_can_be_reached(site: Path) -> None:
    navigation = (site / "index.html").read_text(encoding="utf-8")
    assert [p for p in PAGES if f'href="{p.with_suffix(".html")}"' not in navigation] == []


def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        html = page.read_text(encoding="utf-8")
        resources = re.findall(r"<(?:script|img|iframe|link)\b[^>]*>", html)
        assert [r for r in resources if re.search(r'(?:src|href)="?(?:https?:)?//', r)] == []


def test_the_search_works_from_the_folder_without_a_network(site: Path) -> None:
    with chromium() as browser:
        page = browser.new_page()
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(f"{site.as_uri()}/index.html")
        # By its keys: the search listens to these.
        box = page.locator("input[data-md-component=search-query]")
        box.press_sequentially("integrating factor")
        page.wait_for_selector(".md-search-result__item a", state="attached")
        found = page.eval_on_selector_all(
            ".md-search-result__item a", "all => all.map(a => a.href)"
        )
        assert any("theory/motion.html" in address for address in found)
        assert [url for url in asked if not url.startswith(("file:", "data:"))] == []


def test_the_start_page_shows_the_loop(site: Path) -> None:
    start = (site / "index.html").read_text(encoding="utf-8")
    picture = re.search(r'<img [^>]*src="([^"]+)"', start)
    assert picture is not None
    assert (site / picture[1]).stat().st_size > 10_000
    steps = sections(start)["find-the-missing-effect"]
    places = [steps.index(f"avahazard {c}") for c in ("calibrate", "compare", "diagnose", "add")]
    assert places == sorted(places)


def test_equations_are_drawn(site: Path) -> None:
    for page in site.rglob("*.html"):
        assert "language-math" not in page.read_text(encoding="utf-8"), page
