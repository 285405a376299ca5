"""What all forms share: kinds of values, and the check of a table row by row."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import PydanticCustomError

from avahazard.records.errors import RowProblem


def _plain_number(text: str) -> str:
    """Refuse what Python reads as a number but a table does not mean as one, such as 1_000."""
    if "_" in text:
        raise ValueError(text)
    return text


def _plain_flag(text: str) -> str:
    """Take 0.0 and 1.0 too: so writes a table program a column with empty cells."""
    return {"0.0": "0", "1.0": "1"}.get(text, text)


PLAIN = BeforeValidator(_plain_number)
Name = Annotated[str, Field(min_length=1, max_length=200)]
Number = Annotated[float, Field(allow_inf_nan=False), PLAIN]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), PLAIN]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False), PLAIN]
Year = Annotated[int, Field(ge=1, le=9999), PLAIN]
Flag = Annotated[bool, BeforeValidator(_plain_flag)]

ID = "an identifier of 1 to 200 characters"
ELEVATION = "an elevation in metres above sea level"


class Row(BaseModel):
    """One row of a file; a field's description is what would be accepted there."""

    model_config = ConfigDict(extra="ignore", frozen=True)


R = TypeVar("R", bound=Row)


def wrong(column: str, accepted: str) -> PydanticCustomError:
    """Build the error of a check over several columns, shown at `column`."""
    return PydanticCustomError("row", "row", {"column": column, "accepted": accepted})


def check_rows(
    form: type[R],
    file: str,
    rows: Iterator[tuple[int, dict[str, str]]],
    problems: list[RowProblem],
    *,
    context: dict[str, bool] | None = None,
) -> Iterator[tuple[int, R]]:
    """Yield the rows that keep to `form`; add the others' faults to `problems`."""
    for line, cells in rows:
        try:
            yield line, form.model_validate(cells, context=context)
        except ValidationError as error:
            problems.extend(_row_problems(form, file, line, cells, error))


def _row_problems(
    form: type[Row], file: str, line: int, cells: dict[str, str], error: ValidationError
) -> Iterator[RowProblem]:
    for fault in error.errors(include_url=False):
        if fault["type"] == "row":
            column, accepted = fault["ctx"]["column"], fault["ctx"]["accepted"]
        else:
            column = str(fault["loc"][0])
            accepted = form.model_fields[column].description or ""
        yield RowProblem(file, line, column, cells.get(column, ""), accepted)
