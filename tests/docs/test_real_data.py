"""The page of real records is that of the kept results, and its regression is right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.real_data import FOUND, addable, regression, split, tables
from benchmarks.study import DOCS, lines, with_parts


def test_the_page_is_what_came_out() -> None:
    found = tables(lines(FOUND))
    written = (DOCS / "real-data.md").read_text(encoding="utf-8")
    assert with_parts(written, found) == written
    assert len(found) == 3


def test_the_third_is_drawn_without_the_rest(tmp_path: Path) -> None:
    text = "event_id,volume_m3\n" + "".join(f"e{k},1\n" for k in range(30))
    (tmp_path / "all.csv").write_text(text, encoding="utf-8")
    learnt, kept = (f.read_text() for f in split(tmp_path / "all.csv", tmp_path))
    names = [set(part.split()[1:]) for part in (learnt, kept)]
    assert [len(part) for part in names] == [20, 10]
    assert not names[0] & names[1]


@pytest.mark.parametrize(
    ("verdict", "missing", "added"),
    [
        ("missing-effect", ["season"], True),
        ("ambiguous", ["season", "snow-type"], False),
        ("unexplained", ["covariate:slope"], True),
        ("unexplained", ["speed:predicted_speed_m_s"], False),
        ("adequate", [], False),
    ],
)
def test_what_a_user_would_add(verdict: str, missing: list[str], added: bool) -> None:
    assert addable({"verdict": verdict, "missing": missing}) == added


def test_the_regression_finds_what_was_put_in(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    files = []
    for name, n in (("learnt.csv", 400), ("kept.csv", 200)):
        log_v, side = rng.normal(12.0, 1.5, n), rng.integers(0, 2, n)
        ratio = np.exp(-1.0 - 0.1 * log_v - 0.3 * side + 0.2 * rng.standard_normal(n))
        rows = zip(log_v, side, ratio, strict=True)
        text = "event_id,fall_height_m,runout_length_m,volume_m3,side\n" + "".join(
            f"e,1000,{1000 / r},{np.exp(v)},{'ab'[s]}\n" for v, s, r in rows
        )
        files.append(tmp_path / name)
        files[-1].write_text(text, encoding="utf-8")
    found = regression(*files, ("side",))
    terms = found["coefficients"]
    assert abs(terms["log V"]["value"] + 0.1) < 3.0 * terms["log V"]["se"]
    assert abs(terms["side b"]["value"] + 0.3) < 3.0 * terms["side b"]["se"]
    assert found["p_extra"] < 1e-6
    assert abs(found["coverage_90"] - 0.9) < 0.07
    bare = regression(*files, ())
    assert found["crps_m"] < bare["crps_m"]
    assert found["elpd"] > bare["elpd"]
