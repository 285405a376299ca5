"""The text of a file, whatever wrote it: UTF-8, UTF-16 or Windows-1252."""

from __future__ import annotations

import codecs
import re

from avahazard.records.errors import RowProblem

ACCEPTED = "a text file in UTF-8 (in a spreadsheet: save as .xlsx, or as 'CSV UTF-8')"
MARKS = (
    (codecs.BOM_UTF8, "utf-8", "UTF-8 with a byte order mark"),
    (codecs.BOM_UTF32_LE, "utf-32-le", "UTF-32"),
    (codecs.BOM_UTF32_BE, "utf-32-be", "UTF-32"),
    (codecs.BOM_UTF16_LE, "utf-16-le", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16-be", "UTF-16"),
)
WORD = re.compile(r"\w*[^\W\x00-\x7f]\w*")
# Signs that no word holds at these places: what letters of other code pages become in cp1252.
FOREIGN = re.compile(
    "(?<=[^\\W\\d_])(?:[‚ƒ„…†‡ˆ‰‹]|[ŠŒŽŸ](?=[a-z])|[“”•–—˜™›¡¢£¤¥¦§¨©«¬®¯±´¶·¸»¼½¾¿×÷](?=[^\\W\\d_]))"
)


def decode(file: str, raw: bytes, problems: list[RowProblem]) -> tuple[str, str] | None:
    """Return the text of `raw` and the name of its encoding; None after adding to `problems`.

    A byte order mark decides; else UTF-8 where it is valid; else Windows-1252, unless it gives
    words that no language writes.
    """
    for mark, codec, name in MARKS:
        if raw.startswith(mark):
            return _strict(file, raw[len(mark) :], codec, name, problems)
    if unmarked := _without_mark(raw):
        return _strict(file, raw, unmarked, "UTF-16", problems)
    try:
        return _no_zero(file, raw.decode("utf-8"), "UTF-8", problems)
    except UnicodeDecodeError as error:
        at = error.start
    found = _strict(file, raw, "cp1252", "Windows-1252", problems)
    if found is None:
        return None
    text = found[0]
    if wrong := FOREIGN.search(text):
        line = text.count("\n", 0, wrong.start()) + 1
        problems.append(RowProblem(file, line, "", f"byte 0x{raw[wrong.start()]:02x}", ACCEPTED))
        return None
    words = [word for word in WORD.findall(text) if any(c > "\x7f" and c.isalpha() for c in word)]
    example = f" (such as {words[0]!r})" if words else f" (byte 0x{raw[at]:02x})"
    return text, f"Windows-1252{example}"


def _strict(
    file: str, raw: bytes, codec: str, name: str, problems: list[RowProblem]
) -> tuple[str, str] | None:
    try:
        return _no_zero(file, raw.decode(codec), name, problems)
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        problems.append(RowProblem(file, line, "", f"byte 0x{raw[error.start]:02x}", ACCEPTED))
        return None


def _no_zero(file: str, text: str, name: str, problems: list[RowProblem]) -> tuple[str, str] | None:
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        problems.append(RowProblem(file, line, "", "byte 0x00", ACCEPTED))
        return None
    return text, name


def _without_mark(raw: bytes) -> str | None:
    """UTF-16 without its mark shows by zeros at every other byte of an ASCII header."""
    head = raw[:200]
    even, odd = head[::2].count(0), head[1::2].count(0)
    if odd > 0.4 * len(head) and even == 0:
        return "utf-16-le"
    if even > 0.4 * len(head) and odd == 0:
        return "utf-16-be"
    return None
