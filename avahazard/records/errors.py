"""Errors that a user can correct: one message, one hint, and the rows at fault."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches


class AvahazardError(Exception):
    """The data or the database do not allow what was asked (exit status 1)."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        """The message with its hint."""
        return f"{self.message} {self.hint}".rstrip()


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise Ctrl-C as what it is: within compiled code it is the cause of a SystemError, or two."""
    try:
        yield
    except SystemError as error:
        cause: BaseException | None = error
        while isinstance(cause, SystemError):
            cause = cause.__cause__
        if isinstance(cause, KeyboardInterrupt):
            raise cause from None
        raise


@dataclass(frozen=True, slots=True)
class RowProblem:
    """One rejected value: where it stands and what would be accepted."""

    file: str
    line: int
    column: str
    value: str
    accepted: str


Problems = list[RowProblem]


MOST_LISTED = 10


class RejectedRows(AvahazardError):  # noqa: N818
    """Files hold rows that cannot be taken: `problems` are all of them, its text has the first."""

    def __init__(self, problems: Sequence[RowProblem]) -> None:
        n = len(problems)
        rows = "1 value is" if n == 1 else f"{n} values are"
        super().__init__(
            f"{rows} not acceptable; nothing was imported.",
            "Correct what is listed above and import again.",
        )
        self.problems = tuple(problems)

    def __str__(self) -> str:
        """The first problems, a line each, then the message with its hint."""
        lines = [
            f"{p.file}, line {p.line}, {p.column}: '{p.value}'; right is {p.accepted}"
            for p in self.problems[:MOST_LISTED]
        ]
        more = len(self.problems) - len(lines)
        return "\n".join([*lines, *([f"and {more} more"] if more else ()), super().__str__()])


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question with the names that are close to `name`, and a blank; empty where none is."""
    close = get_close_matches(name, list(known), n=2)
    return f"Did you mean {' or '.join(close)}? " if close else ""


def told_once(problems: Sequence[RowProblem]) -> list[RowProblem]:
    """Return `problems` by file and line, of several of one cell the first."""
    first: dict[tuple[str, int, str, str], RowProblem] = {}
    for problem in problems:
        cell = (problem.file, problem.line, problem.column, problem.value)
        first.setdefault(cell, problem)
    return sorted(first.values(), key=lambda problem: (problem.file, problem.line))
