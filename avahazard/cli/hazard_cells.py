"""Places, volumes and return periods as they stand in tables of runouts."""

from __future__ import annotations

from avahazard.results.hazard import HazardRow, PlaceQuantiles, Spread

BEYOND, FAR = "beyond", "*"


def period_text(row: HazardRow) -> str:
    """The return period in years, marked where it is an extrapolation."""
    period = row.return_period_years
    mark = FAR if row.extrapolated else ""
    return "–" if period is None else f"{period:g}{mark}"


def range_text(spread: Spread | PlaceQuantiles) -> str:
    """5 to 95 % of a place."""
    return f"{metres_text(spread.q05)}–{metres_text(spread.q95)}"


def share_text(value: float) -> str:
    """A share of draws in percent."""
    return "0" if value == 0.0 else f"{value:.1%}"


def metres_text(value: float | None) -> str:
    """Whole metres, or a word for places past the end of the profile."""
    return BEYOND if value is None else f"{value:.0f}"


def volume_text(volume: float | None) -> str:
    """A volume to three digits: its own error is larger."""
    if volume is None:
        return "any"
    if volume < 1e6:
        return f"{float(f'{volume:.3g}'):.0f}"
    return f"{volume:.2e}".replace("e+0", "e")
