"""What all results share: JSON, pandas, pictures, how a notebook shows them, and units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar, dataclass_transform, get_args

from avahazard.notes import Note
from avahazard.records.errors import AvahazardError

if TYPE_CHECKING:
    import pandas as pd

AS_THEY_ARE = frozenset((str, int, bool, type(None)))


def plain(value: Any, *, keyed: bool = False) -> Any:
    """Return `value` as dicts, lists, text, numbers and None.

    Arrays become lists, numpy scalars Python ones, and NaN or an infinity None. A dataclass gives
    its fields by `key_of`; those marked `absent` are left out where they are None. A note is its
    sentence or, `keyed`, its key and values, as the database holds it.
    """
    if type(value) in AS_THEY_ARE:
        return value
    if isinstance(value, float):
        return finite(value)
    if isinstance(value, Note):
        value = value.stored() if keyed else str(value)
    elif is_dataclass(value):
        value = {
            key_of(field.name): item
            for field in fields(value)
            if (item := getattr(value, field.name)) is not None or not field.metadata.get("absent")
        }
    if hasattr(value, "tolist"):
        return plain(value.tolist(), keyed=keyed)
    if isinstance(value, Mapping):
        return {str(key): plain(item, keyed=keyed) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, keyed=keyed) for item in value]
    return value


def finite(value: float) -> float | None:
    """A number; None for NaN and the infinities."""
    return float(value) if math.isfinite(value) else None


def key_of(field: str) -> str:
    """The key of a field: its name, without the underscore after a word of Python."""
    return field.removesuffix("_")


Row_co = TypeVar("Row_co", covariant=True)
Draw = Callable[[Path, Any], None]
Report = Callable[[str, float], None]
"""Called as long work goes on: what is done, and how much of it, from 0 to 1."""
ABSENT = {"absent": True}
"""Metadata of a field that is left out of the JSON where it is None."""
PICTURES: dict[type, Draw] = {}
"""How a result is drawn to a file, by its class; filled by `avahazard.report.picture`."""
RATIO = "h_over_l"
"""The coordinate of records of which H/L alone is known; keys that end in `_m` then hold H/L."""


def silent(_what: str, _share: float) -> None:
    """A `Report` that does nothing."""


def steps(report: Report, weights: Sequence[float]) -> list[Report]:
    """A report for each step that reports to `report` on the whole: step k is `weights[k]` of it.

    The whole goes from 0 to 1 and never back, whatever a step reports of itself.
    """
    whole = float(sum(weights))

    def step(start: float, weight: float, what: str, share: float) -> None:
        report(what, start + weight * min(max(share, 0.0), 1.0))

    return [
        partial(step, sum(weights[:k]) / whole, weight / whole) for k, weight in enumerate(weights)
    ]


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
@dataclass(frozen=True, repr=False)
class Result:
    """A result: its fields are the keys of its JSON, less an underscore after a word of Python.

    Its classes are frozen dataclasses without a decorator, shown in short.
    """

    __pydantic_config__: ClassVar[dict[str, Any]] = {"alias_generator": key_of}

    def __init_subclass__(cls, *, kw_only: bool = False) -> None:
        """Make a dataclass of it."""
        dataclass(frozen=True, repr=False, kw_only=kw_only)(cls)

    def __repr__(self) -> str:
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        parts = [f"{name}={_brief(v)}" for name, v in values.items() if v is not None and v != ()]
        return f"{type(self).__name__}({', '.join(parts)})"

    def to_dict(self) -> dict[str, Any]:
        """Return it as dicts, lists, text, numbers and None: what `--json` prints."""
        document: dict[str, Any] = plain(self)
        return document

    @classmethod
    def from_dict(cls, document: dict[str, Any]) -> Self:
        """Return the result of a document that `to_dict` made."""
        result: Self = reader_of(cls)(document)  # type: ignore[arg-type]
        return result

    def to_frame(self) -> pd.DataFrame:
        """Return it as a frame of pandas; nested keys are joined by dots.

        A result that is a list, of rows or of events, has a row for each of these, another one row.
        """
        for name in ("rows", "events"):
            if isinstance(found := getattr(self, name, None), Rows):
                return found.to_frame()
        return Rows([self]).to_frame()

    def plot(self, file: str | Path | None = None) -> Any:
        """Draw it, to `file` (.png, .svg, .pdf) or to be shown by a notebook.

        Raises `AvahazardError` where there is no picture of this result.
        """
        if type(self) not in PICTURES:
            known = ", ".join(sorted(kind.__name__ for kind in PICTURES))
            raise AvahazardError(f"There is no picture of {type(self).__name__}.", f"Of: {known}.")
        return drawn(lambda place: PICTURES[type(self)](place, self), file)

    def _repr_html_(self) -> str:
        frame = self.to_frame()
        # A row is easier read downwards.
        return _html(frame.T, header=False) if len(frame) == 1 else _html(frame, index=False)


class Rows(tuple[Row_co, ...]):
    """Results in a row, such as the candidates of a diagnosis: a tuple with a frame."""

    __slots__ = ()

    def to_frame(self) -> pd.DataFrame:
        """Return one row each; nested keys are joined by dots."""
        import pandas as pd  # noqa: PLC0415 (slow to import)

        frame = pd.json_normalize(plain(self))
        # Columns of one's own have their names, as in the file that they come from.
        return frame.rename(columns=lambda name: name.removeprefix("covariates."))

    def __repr__(self) -> str:
        kinds = " or ".join(dict.fromkeys(type(row).__name__ for row in self))
        return f"Rows({len(self)} {kinds})".replace(" )", ")")

    def _repr_html_(self) -> str:
        return _html(self.to_frame(), index=False)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Any:
        from pydantic_core import core_schema  # noqa: PLC0415 (slow to import)

        items = core_schema.tuple_variable_schema(handler.generate_schema(*get_args(source)))
        return core_schema.no_info_after_validator_function(cls, items)


def drawn(write: Callable[[Path], Any], file: str | Path | None) -> Any:
    """What `write` draws, in `file`, or as an image that a notebook shows."""
    import tempfile  # noqa: PLC0415

    if file is not None:
        write(Path(file))
        return Path(file)
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.svg"
        write(picture)
        return Picture(picture.read_text(encoding="utf-8"))


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as SVG, which a notebook shows."""

    svg: str = field(repr=False)

    def _repr_svg_(self) -> str:
        return self.svg


@cache
def reader_of(kind: Any) -> Callable[[Any], Any]:
    """A function that reads a dataclass of this kind from a document that `plain` made of one."""
    from pydantic import TypeAdapter  # noqa: PLC0415 (slow to import)

    return TypeAdapter(kind).validate_python


LONGEST = 60


def _brief(value: Any) -> str:
    if isinstance(value, Result):
        return f"{type(value).__name__}(…)"
    if isinstance(value, list | tuple | dict) and value:
        return f"<{len(value)}>"
    text = f"{value:.6g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def _html(frame: pd.DataFrame, **how: Any) -> str:
    """The frame as HTML; what is a list stands as its texts, or as their number."""
    return str(frame.map(_in_cell).to_html(**how))


def _in_cell(value: Any) -> Any:
    if not isinstance(value, list):
        return value
    texts = [item for item in value if isinstance(item, str)]
    return "; ".join(texts) if len(texts) == len(value) else f"{len(value)} entries"
