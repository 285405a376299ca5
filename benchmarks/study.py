"""What studies share: results as lines of JSON, what is missing done, tables written into pages."""

from __future__ import annotations

import gzip
import json
import multiprocessing
import re
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
HERE, DOCS, SHARED = ROOT / "benchmarks", ROOT / "docs", ROOT.parent / "shared" / "data"
Line = dict[str, Any]


def lines(file: Path) -> list[Line]:
    """The results in `file`, of each name the last; none where there is no such file yet."""
    if not file.exists():
        return []
    with _open(file, "rt") as kept:
        return list({line["name"]: line for line in map(json.loads, kept)}.values())


def keep(file: Path, line: Line) -> None:
    """Append a result; a run that is cut short then goes on from it."""
    with _open(file, "at") as out:
        out.write(json.dumps(line, ensure_ascii=False) + "\n")


def _open(file: Path, mode: str) -> Any:
    """Many results are kept compressed, in a file that ends in .gz."""
    return (gzip.open if file.suffix == ".gz" else open)(file, mode, encoding="utf-8")


def run_missing(
    file: Path,
    plans: Iterable[tuple[str, Any]],
    judge: Callable[[Any], Line],
    *,
    minutes: float = 1e6,
    workers: int = 1,
) -> list[Line]:
    """Judge the plans, given with their names, that have no result in `file`; all its results.

    No plan is begun after so many minutes.
    """
    done = {line["name"] for line in lines(file)}
    left = iter([plan for plan in plans if plan[0] not in done])
    until = time.monotonic() + 60.0 * minutes
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        running = {}

        def begin() -> None:
            if time.monotonic() < until and (plan := next(left, None)) is not None:
                running[pool.submit(judge, plan[1])] = plan[0], time.monotonic()

        for _ in range(workers):
            begin()
        while running:
            future = next(as_completed(running))
            name, began = running.pop(future)
            keep(file, {"name": name, **future.result()})
            print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)
            begin()
    return lines(file)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown; whole numbers with commas at thousands."""
    cells = [[f"{v:,}" if isinstance(v, int) else str(v) for v in row] for row in rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *cells))


def bullets(texts: Iterable[str], none: str) -> str:
    """The texts as a list, or the sentence that there are none."""
    return "\n".join(f"- {text}" for text in texts) or none


def with_parts(text: str, parts: dict[str, str]) -> str:
    """A page whose marked parts (`<!-- NAME -->` to `<!-- end of NAME -->`) are these.

    Raises:
        ValueError: the page has no such part.
    """
    for name, part in parts.items():
        mark = re.compile(rf"(?<=<!-- {name} -->\n).*?(?=<!-- end of {name} -->)", re.DOTALL)
        if not mark.search(text):
            raise ValueError(f"the page has no part {name}")
        text = mark.sub(lambda _, part=part: f"\n{part.strip()}\n\n", text)
    return text


def write_parts(page: Path, parts: dict[str, str]) -> None:
    """Write these parts into a page; the rest of it is written by hand."""
    page.write_text(with_parts(page.read_text(encoding="utf-8"), parts), encoding="utf-8")
