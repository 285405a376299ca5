"""What a user says of a file that does not say it itself."""

from __future__ import annotations

from dataclasses import dataclass

from avahazard.records.files.dates import Order
from avahazard.records.files.numbers import Decimal


@dataclass(frozen=True, slots=True)
class Conventions:
    """The decimal sign, and whether day or month comes first; None: the file shows it.

    `unusual`: numbers beyond those of snow avalanches are meant so, and need no note.
    """

    decimal: Decimal | None = None
    dates: Order | None = None
    unusual: bool = False


UNKNOWN = Conventions()
