"""Notes: their English sentences, how they are stored, how many are put together."""

from __future__ import annotations

import ast
import json
import pickle
from pathlib import Path
from string import Formatter

import pytest

from avahazard.notes import ENGLISH, SENTENCES, TERMINAL, Note, grouped, placed
from avahazard.results.base import plain

PACKAGE = Path(__file__).parents[1] / "avahazard"
PARTS = [Note("of_parameters"), Note("of_rate_error")]
INTERVAL = Note("interval_design", parts=PARTS, mixed=[Note("of_release")])
MISSES = Note("misses_points", "P1", away=12.4, x=310.0)


def test_a_note_is_its_sentence() -> None:
    assert Note("stale", model="base") == "the records have changed since base was calibrated."
    assert MISSES.startswith("P1: the path that the block runs on misses the points of its profile")
    assert "by 12 m at x = 310 m." in MISSES
    assert "uncertainty of the calibrated parameters, error of the rate. The design" in INTERVAL
    assert Note("few_events", model="m", n=1) == "m is based on 1 event only."
    assert "60,000 m3" in Note("largest_volume", model="m", largest=6e4)


def test_a_model_in_a_command_is_as_a_shell_takes_it() -> None:
    said = str(Note("not_compared", model="base+interaction:a*b"))
    assert said.endswith("Do it: avahazard compare 'base+interaction:a*b'")
    assert str(Note("not_compared", model="base")).endswith("avahazard compare base")


@pytest.mark.parametrize("note", [MISSES, INTERVAL, Note.ready("as it was said before.")])
def test_what_is_stored_gives_the_same_note(note: Note) -> None:
    stored = json.loads(json.dumps(plain(note, keyed=True)))
    read = Note.read(stored)
    assert (read, read.key, read.of, read.values) == (note, note.key, note.of, note.values)
    assert pickle.loads(pickle.dumps(note)).stored() == note.stored()
    assert plain({"notes": (note,)}) == {"notes": [str(note)]}


def test_sentences_of_old_databases_and_keys_of_later_versions_are_read() -> None:
    assert Note.read("the records have changed since base was calibrated.").key == ""
    assert str(Note.read({"key": "of_2030", "values": {"share": 0.5}})) == "of_2030, share 0.5"


def test_a_number_that_is_not_known_is_a_dash() -> None:
    note = Note("not_converged", rhat=None, ess=3.0)
    assert "R-hat –, smallest effective sample size 3" in note
    assert Note.read(json.loads(json.dumps(note.stored()))) == note
    assert len(grouped([note, Note("not_converged", rhat=1.2, ess=9.0)])) == 2


def test_notes_of_one_kind_are_one_with_ranges_and_the_first_paths() -> None:
    many = [Note("misses_points", f"P{k}", away=10.0 + k, x=300.0) for k in range(25)]
    stale = Note("stale", model="base")
    one, other = grouped([*many, stale, many[0], stale])
    assert one.startswith("P0, P1, P2 and 22 more: the path that the block runs on")
    assert "by 10 to 34 m at x = 300 m" in one
    assert other == stale


def test_sentences_in_a_row_begin_with_capitals_but_for_names() -> None:
    notes = [Note("any_volume"), Note("few_events", model="m", n=1), MISSES, Note.ready("a b.")]
    found = " ".join(map(ENGLISH.alone, notes))
    assert found.startswith("This model's friction is the same for every volume. m is based on")
    assert "event only. P1: the path" in found
    assert found.endswith(" a b.")


def test_volumes_of_several_paths_are_one_sentence() -> None:
    of = {"largest": 4e5, "largest_of_path": 6e4}
    notes = [
        Note("beyond_path", f"P{k}", volume=1e5 * k, times_path=1.5 * k, times=1.0, **of)
        for k in (1, 2)
    ]
    (one,) = grouped(notes)
    assert "100,000 to 200,000 m3, is 1.5 to 3 times the largest recorded on this path:" in one


def test_notes_that_differ_in_words_stay_apart() -> None:
    notes = [Note("prior_dominated", parameter=p, model="m", moved=0.1, width=0.9) for p in "ab"]
    assert grouped(notes) == notes
    assert grouped(["one", "two", "one"]) == ["one", "two"]


def test_things_of_several_paths_are_counted_together_and_their_names_joined() -> None:
    notes = [
        Note("above_limit", f"P{k}", n=3, limit=600.0, events=events, elevation=650.0 + k)
        for k, events in enumerate((["a0", "b0", "c0"], ["a1", "b1", "c1"]))
    ]
    (one,) = grouped(notes)
    assert one.startswith("P0, P1: 6 records stop above observed_below_m (600 m)")
    assert "events a0, b0, c0 and 3 more, up to 650 to 651 m" in one


def test_one_or_two_more_are_named() -> None:
    assert ENGLISH.few("abcde") == "a, b, c, d, e"
    assert ENGLISH.few("abcdef") == "a, b, c and 3 more"


def test_zero_has_no_sign() -> None:
    assert Note("number", value=-0.0) == "0"
    assert [ENGLISH.number(text) for text in ("-0.00", "-0 %", "-0.01")] == ["0.00", "0 %", "-0.01"]


def test_a_note_on_all_of_several_paths_names_none() -> None:
    note = Note("any_volume")
    assert placed({note: ["P1", "P2"]}, 2) == [note]
    assert placed({note: ["P1"]}, 1) == [f"P1: {note}"]
    assert placed({Note.ready("old."): ["P1", "P2"]}, 3) == ["P1, P2: old."]


def places(sentence: str | tuple[str, str]) -> set[str]:
    """The names of its places; of a count, also `n`."""
    texts = (sentence,) if isinstance(sentence, str) else sentence
    named = {name for text in texts for _, name, _, _ in Formatter().parse(text) if name}
    return named | ({"n"} if len(texts) > 1 else set())


def test_every_note_that_is_made_has_a_sentence_and_the_values_of_its_places() -> None:
    made = set()
    known = SENTENCES | TERMINAL
    for file in set(PACKAGE.rglob("*.py")) - {PACKAGE / "notes.py"}:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value in known:
                made.add(node.value)
            if not (isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Note"):
                continue
            key = node.args[0]
            if isinstance(key, ast.Constant):
                given = {keyword.arg for keyword in node.keywords}
                assert None in given or places(known[key.value]) <= given, (file, key.value)
    assert made >= SENTENCES.keys() | TERMINAL.keys()
