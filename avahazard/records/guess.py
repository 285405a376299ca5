"""A first `columns.toml`: what the columns of a table seem to be, by their names and contents."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np
from rapidfuzz import fuzz, process

from avahazard.notes import ENGLISH, counted
from avahazard.records.cells import LIKELY_MARKS, RANGE, usual_of_range
from avahazard.records.conventions import ISO, is_number, read_dates
from avahazard.records.errors import Problems
from avahazard.records.forms import Kind, required
from avahazard.records.intake import Guess
from avahazard.records.meanings import ABOVE_SEA, MEANINGS, NAMES, known_unit, squash
from avahazard.records.rows import PathRow
from avahazard.records.sheet import read_tables
from avahazard.records.table import FileTable, SheetLayout

DATE_PARTS = ("year", "month", "day")
FROM_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]|[,;]\s*(\S+)$|_(m3|m2|m|km3|km|ft|ha)$")
PLAIN = re.compile(r"[0-9]+(?:\.[0-9]*)?")
OF_PROFILES = {"path_id", "x_m", "y_m", "land_cover", "easting_m", "northing_m", "lon", "lat"}
OF_TERRAIN = OF_PROFILES | PathRow.model_fields.keys()
WITHOUT_PATH = {"fall_height_m", "runout_length_m", "h_over_l"}
REMARKS = frozenset(
    ("remarks", "remark", "comments", "comment", "notes", "note", "source", "observer",
     "bemerkungen", "bemerkung", "kommentar", "kommentare", "notizen", "quelle", "beobachter",
     "remarques", "remarque", "commentaire", "commentaires", "observations", "observateur",
     "osservazioni", "commenti", "commento", "fonte", "osservatore", "merknad", "merknader",
     "kilde")
)  # fmt: skip
"""Names of columns that say nothing of an avalanche which a model could use."""
MOST_TOTALS = 0.05
"""Share of the rows without a path, at most, that are taken for totals and other remarks."""
SURE, LIKELY, NEAR = 0.95, 0.8, 87.0
"""Confidence in a name of the list, least one that is written, and least likeness (of 100)."""


class GuessedTable(NamedTuple):
    """A table's guesses, what they leave open, and where its header and units stand.

    `keep` are the columns that stay as one's own, where not all others do; rows without `need` are
    left out, as those of totals are.
    """

    table: FileTable
    layout: SheetLayout
    guesses: tuple[Guess, ...]
    open: tuple[str, ...]
    unknown: tuple[str, ...]
    keep: list[str] | None
    need: list[str]


def guess_tables(file: FilePath) -> tuple[list[GuessedTable], Problems]:
    """Guess every table of a file; what of it cannot be read is returned too."""
    faults: Problems = []
    heads = read_tables(file, faults, SheetLayout(guess=True))
    found = []
    for head in heads:
        row = [column.texts[0] for column in head.columns.values() if len(head.lines)]
        words = [text for text in row if text and not is_number(text)]
        units = len(words) == sum(map(bool, row)) and 2 * sum(map(_any_unit, words)) >= len(words)
        merged = any("merged" in fault.value for fault in faults if fault.file == head.file)
        layout = SheetLayout(head.first, head.lines[0] if words and units else None, merged)
        tables = read_tables(file, [], layout)
        found += [_guessed(table, layout) for table in tables if table.title == head.title]
    return found, [] if heads else faults


def _any_unit(text: str) -> bool:
    return not is_number(text) and any(
        known_unit(text, unit) for unit in (ABOVE_SEA, "m", "m3", "m2", "m/s", "degrees", "years")
    )


def _guessed(table: FileTable, layout: SheetLayout) -> GuessedTable:
    candidates = [guess for name in table.header for guess in _candidates(table, name)]
    likely = {guess.column for guess in candidates if guess.confidence >= LIKELY}
    profile = likely >= {"x_m", "y_m"} and not likely & {"date", "volume_m3"}
    others = likely - OF_PROFILES if profile else {"x_m", "y_m", "land_cover"}
    candidates = [guess for guess in candidates if guess.column not in others]
    candidates.sort(key=lambda guess: -guess.confidence)
    taken, open_ = _chosen(candidates)
    for guess in taken.values():
        unit = MEANINGS[guess.column].unit if guess.column in MEANINGS else ""
        if guess.ranges:
            which = usual_of_range(guess.column)
            open_.append(f'{guess.source!r} holds ranges: range = "{which}" is taken')
        open_ += _other_words(table, guess)
        if unit in ("m", "m3", "m a.s.l.") and not guess.unit:
            open_.append(f"the unit of {guess.source!r} is not said: {unit} is assumed")
    unused = [n for n in table.header if n not in {g.source for g in taken.values()}]
    remarks = [name for name in unused if squash(name) in REMARKS]
    own = [name for name in unused if name not in remarks]
    if own:
        open_.append(f"kept as columns of your own: {', '.join(map(repr, own))}")
    if remarks:
        open_.append(f"left out (not in keep): {', '.join(map(repr, remarks))}")
    drop, reach = taken.get("fall_height_m"), taken.get("runout_length_m")
    if drop and reach and drop.unit == reach.unit and _middle(table, reach) < _middle(table, drop):
        open_.append(f"{reach.source!r} is mostly below {drop.source!r}: is it in km?")
    every = (text for name in table.header for text in table.counts(name))
    unknown = dict.fromkeys(text for text in every if text.casefold() in LIKELY_MARKS)
    open_ += _lacking(taken, profile)
    need: list[str] = []
    # Events with H and L, or H/L, may have no path.
    if (path := taken.get("path_id")) and not taken.keys() & WITHOUT_PATH:
        without = sum(not text for text in table.columns[path.source].texts)
        if 0 < without <= MOST_TOTALS * len(table.lines):
            need = [path.source]
            open_.append(f"{counted(without, 'row')} without {path.source!r} left out (need)")
    guesses, keep = tuple(taken.values()), own if remarks else None
    return GuessedTable(table, layout, guesses, tuple(open_), tuple(unknown), keep, need)


def _chosen(candidates: Sequence[Guess]) -> tuple[dict[str, Guess], list[str]]:
    """Of guesses, the surest first, those that are taken, by column, and what stays open."""
    taken: dict[str, Guess] = {}
    open_: list[str] = []
    for guess in candidates:
        same = next((other for other in taken.values() if other.source == guess.source), None)
        if same and same.confidence == guess.confidence and guess.column not in taken:
            open_.append(f"{guess.source!r} may also be {guess.column}, not {same.column}")
        if same:
            continue
        rival = taken.get(guess.column)
        if rival and rival.confidence == guess.confidence:
            open_.append(f"{guess.source!r} or {rival.source!r} is {guess.column}: which one?")
        elif not rival and guess.confidence >= LIKELY:
            taken[guess.column] = guess
        elif not rival:
            sure = f"{guess.confidence:.0%}: {guess.reason}"
            open_.append(f"{guess.source!r} may be {guess.column} ({sure})")
    return taken, open_


def _other_words(table: FileTable, guess: Guess) -> Iterator[str]:
    """The words of a column with known values that are none of them."""
    known = MEANINGS[guess.column].values if guess.column in MEANINGS else {}
    others = set(_words(table, guess.source)) - guess.classes.keys() - known.keys()
    if known and others:
        few = ENGLISH.few(sorted(map(repr, others)))
        yield f"{guess.source!r} has {few}, which is not {' or '.join(known)}"


def _lacking(taken: Mapping[str, Guess], profile: bool) -> Iterator[str]:
    """The columns that the form of a table requires and that none is taken for."""
    if _without_numbers(taken):
        yield "no column names the events: their rows do (event_id = row number)"
    events = not OF_TERRAIN.issuperset(taken)
    kind: Kind = "events" if events else "profiles" if profile else "paths"
    for names in required(kind, {"event_id", *taken}, need_runout=True):
        if names != ("event_id",) and not set(names) & set(taken):
            yield f"no column seems to be {' or '.join(names[:3])}, which is required"


def _without_numbers(columns: Mapping[str, Guess]) -> bool:
    """Whether a table has events that no column names."""
    return "event_id" not in columns and not OF_TERRAIN.issuperset(columns)


def _middle(table: FileTable, guess: Guess) -> float:
    found = [text.replace(",", ".") for text in table.counts(guess.source).elements()]
    return float(np.median([float(t) for t in found if PLAIN.fullmatch(t)] or [np.nan]))


def _candidates(table: FileTable, name: str) -> Iterator[Guess]:
    """What a column may be, by its name and unit, each held against its contents."""
    given = FROM_UNIT.search(name)
    unit = next((g for g in given.groups() if g), "") if given else table.columns[name].unit
    bare = FROM_UNIT.sub("", name).strip() if given and _any_unit(unit) else name
    unit = unit if _any_unit(unit) else ""
    texts = _words(table, name)
    for column, (word, likeness) in _like(bare).items():
        confidence = SURE if likeness == 100.0 else LIKELY * likeness / 100.0 + 0.04
        reason = f"{bare!r} is {word!r}" if likeness == 100.0 else f"{bare!r} is near {word!r}"
        of_unit = MEANINGS[column].unit if column in MEANINGS else ""
        if unit and of_unit:
            if not known_unit(unit, of_unit):
                continue
            reason += f", in {unit}"
        elif len(word) <= 2 and of_unit:
            confidence -= 0.2
        share = _share(column, texts)
        if share < 0.5:
            continue
        if share < 1.0:
            confidence -= 0.2 * (1.0 - share)
            reason += f", {share:.0%} of its values fit"
        ranges = bool(of_unit) and any(map(RANGE.fullmatch, texts))
        unit = unit if of_unit else ""
        known = _values(column)
        classes = {text: known[squash(text)] for text in texts if squash(text) in known}
        yield Guess(table.file, column, name, unit, reason, round(confidence, 2), ranges, classes)


def _words(table: FileTable, name: str) -> list[str]:
    """The values of a column, each once, without marks of unknown."""
    return [text for text in table.counts(name) if text.casefold() not in LIKELY_MARKS]


@cache
def _values(column: str) -> dict[str, str]:
    """Words for values of a column, as letters and digits, and the value of each."""
    values = MEANINGS[column].values if column in MEANINGS else {}
    return {squash(word): value for value, words in values.items() for word in words}


def _share(column: str, texts: Sequence[str]) -> float:
    """Share of the values that a column could hold."""
    content = MEANINGS[column].content if column in MEANINGS else "number"
    if not texts or content in ("name", "text"):
        return 1.0
    if content in ("flag", "choice"):
        known = {*_values(column), *MEANINGS[column].values}
        return sum(squash(text) in known for text in texts) / len(texts)
    if content == "date":
        dates, faults, _ = read_dates(texts, "dmy")
        good = sum(bool(ISO.fullmatch(date)) for date in dates)
        return max(0, good - len(faults)) / len(texts)
    return sum(is_number(text.lstrip("<>~≈ ")) or "-" in text for text in texts) / len(texts)


def _like(name: str) -> dict[str, tuple[str, float]]:
    """Columns whose words are like a name, with the nearest word and its likeness of 100."""
    found: dict[str, tuple[str, float]] = {}
    for column, words in _squashed().items():
        near = process.extractOne(squash(name), words, scorer=fuzz.ratio, score_cutoff=NEAR)
        if near is not None:
            _, likeness, word = near
            found[column] = word, likeness
    return found


@cache
def _squashed() -> dict[str, dict[str, str]]:
    """Of each column the words that are written for it, with their letters and digits."""
    return {
        column: {word: squash(word) for word in (*words, column)} for column, words in NAMES.items()
    }


_quoted = partial(json.dumps, ensure_ascii=False)


def as_toml(tables: Sequence[tuple[str, GuessedTable]]) -> str:
    """The guesses on tables of files, by name, as a `columns.toml`; its comments say why."""
    files = ", ".join(dict.fromkeys(file for file, _ in tables))
    lines = [f"# What the columns of {files} seem to be. Read it, correct it, then import.", ""]
    for file, found in tables:
        if not found.guesses:
            continue
        table = found.table
        lines += ["[[table]]", f"file = {_quoted(file)}"]
        lines += [f"sheet = {_quoted(table.title)}"] if table.title else []
        lines += [f"header = {found.layout.header}"] if found.layout.header != 1 else []
        lines += [f"units = {found.layout.units}"] if found.layout.units else []
        lines += ["merged = true"] if found.layout.merged else []
        if found.unknown:
            lines.append(f"unknown = [{', '.join(map(_quoted, found.unknown))}]")
        if found.need:
            lines.append(f"need = [{', '.join(map(_quoted, found.need))}]")
        if found.keep is not None:
            lines.append(f"keep = [{', '.join(map(_quoted, found.keep))}]")
        lines += [f"# open: {text}" for text in found.open]
        lines.append("[table.columns]")
        by_column = {guess.column: guess for guess in found.guesses}
        parts = [by_column[p] for p in DATE_PARTS if p in by_column]
        if _without_numbers(by_column):
            lines.append('event_id = {value = "{row}"}')
        for guess in found.guesses:
            source = _quoted(guess.source)
            more = f", unit = {_quoted(guess.unit)}" if guess.unit else ""
            more += f', range = "{usual_of_range(guess.column)}"' if guess.ranges else ""
            classes = ", ".join(f"{_quoted(k)} = {_quoted(v)}" for k, v in guess.classes.items())
            more += f", classes = {{{classes}}}" if classes else ""
            value = f"{{from = {source}{more}}}" if more else source
            said = f"  # {guess.confidence:.0%}: {guess.reason}"
            if guess.column not in DATE_PARTS:
                lines.append(f"{guess.column} = {value}{said}")
        if parts and parts[0].column == "year" and "date" not in by_column:
            sources = ", ".join(_quoted(guess.source) for guess in parts)
            lines.append(f"date = {{from = [{sources}]}}")
        lines.append("")
    return "\n".join(lines)
