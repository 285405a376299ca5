"""Every sentence of the report, gathered by Babel from the program into the catalogues.

    python docs/_tools/catalogues.py

writes new sentences into the catalogues under `avahazard/report/locale`, without a translation, and
takes out those that are gone. A test fails until all are translated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.pofile import read_po, write_po

from avahazard.criticism.scoring.where_it_fails import MONTHS
from avahazard.effects.catalogue import MADE, catalogue
from avahazard.effects.change import change
from avahazard.effects.pairs import interaction
from avahazard.hazard.alpha_beta import REGRESSIONS
from avahazard.hazard.volume_records import WINDOWS
from avahazard.hazard.zones import PRESETS
from avahazard.inference.model.choices import METHODS
from avahazard.inference.model.laws import LAWS
from avahazard.notes import SENTENCES
from avahazard.report.language import EFFECT, LANGUAGES
from avahazard.report.words import NAMES

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "avahazard"
LOCALE = PACKAGE / "report" / "locale"
TEMPLATE = PACKAGE / "report" / "html" / "templates" / "report.html.j2"
JINJA = {"extensions": "jinja2.ext.i18n", "trim_blocks": "true", "lstrip_blocks": "true"}
HEADER = """# Sentences of the report; docs/_tools/catalogues.py finds them.
msgid ""
msgstr ""
"Language: {code}\\n"
"Plural-Forms: {plural}\\n"
"MIME-Version: 1.0\\n"
"Content-Type: text/plain; charset=utf-8\\n"
"Content-Transfer-Encoding: 8bit\\n"

"""


def messages() -> Catalog:
    """All sentences, as a catalogue without translations."""
    found = Catalog()
    for file in sorted(PACKAGE.rglob("*.py")):
        for _, text, _, _ in extract_from_file("python", file, {"say": None, "plural": (1, 2)}):
            found.add(text, locations=[(str(file.relative_to(ROOT)), None)])
    for _, text, _, _ in extract_from_file(
        "jinja2.ext:babel_extract", TEMPLATE, {"_": None, "ngettext": (1, 2)}, options=JINJA
    ):
        found.add(text, locations=[(str(TEMPLATE.relative_to(ROOT)), None)])
    for sentence in (*SENTENCES.values(), *_said_of_itself()):
        found.add(sentence if isinstance(sentence, str) else tuple(sentence))
    for key in (*catalogue(), *(prefix + "{column}" for prefix in MADE)):
        found.add(key, context=EFFECT)
    return found


def _said_of_itself() -> Iterator[str]:
    """What the effects, laws and limits say of themselves; names in tables."""
    for names in NAMES.values():
        yield from names.values()
    for entry in catalogue().values():
        yield entry.meaning
    for made in MADE.values():
        yield made("{column}*{other}" if made is interaction else "{column}").meaning
    yield from (change(scope).meaning for scope in ("all", "several", "years"))
    yield from (law.words for law in LAWS.values())
    yield from (method.words for method in METHODS.values())
    for limits in PRESETS.values():
        yield limits.name
        yield from (zone.name for zone in limits.zones)
    yield from (regression.name.capitalize() for regression in REGRESSIONS)
    yield from MONTHS
    yield from WINDOWS.values()


def catalogue_file(code: str) -> Path:
    """Where the catalogue of a language is."""
    return LOCALE / code / "LC_MESSAGES" / "avahazard.po"


def renew(code: str) -> int:
    """Bring a catalogue up to date; return how many of its sentences have no translation."""
    file, known = catalogue_file(code), Catalog(locale=code)
    if file.is_file():
        with file.open("rb") as handle:
            known = read_po(handle, locale=code)
    fresh = Catalog(locale=code, fuzzy=False)
    for entry in messages():
        if entry.id:
            old = known.get(entry.id[0] if isinstance(entry.id, tuple) else entry.id, entry.context)
            text = old.string if old is not None and old.id == entry.id else None
            fresh.add(entry.id, text, entry.locations, context=entry.context)
    write(fresh, code)
    return sum(1 for entry in fresh if entry.id and not translated(entry.string))


def write(catalogue: Catalog, code: str) -> None:
    """Write a catalogue without dates and names: equal sentences give equal files."""
    text = BytesIO()
    write_po(text, catalogue, 100, no_location=True, omit_header=True, sort_output=True)
    file = catalogue_file(code)
    file.parent.mkdir(parents=True, exist_ok=True)
    header = HEADER.format(code=code, plural=catalogue.plural_forms)
    file.write_text(header + text.getvalue().decode("utf-8"), encoding="utf-8")


def translated(text: str | tuple[str, ...]) -> bool:
    """Whether there is a translation, in all numbers."""
    return bool(text) and (isinstance(text, str) or all(text))


if __name__ == "__main__":
    for name in LANGUAGES[1:]:
        print(f"{name}: {renew(name)} without a translation")
    sys.exit(0)
