"""What a reader of a row of `hazard` must know, in sentences that go with it everywhere."""

from __future__ import annotations

from avahazard.hazard.path_hazard import PathHazard, RisingFriction
from avahazard.results.hazard import HazardRow

WORTH_A_NOTE = 0.05
"""Share of draws from which something is said of them."""
RELEASE_HINT = (
    "Real ones start: check where the releases stand on the profile (release_elevation_m of the "
    "events, else of the path, else its top), and that the volume is like those on record."
)
"""What may be wrong where blocks do not start."""


def row_notes(path: PathHazard, row: HazardRow) -> tuple[str, ...]:
    """The notes on one row, without the name of its path."""
    notes = []
    if row.p_not_released > WORTH_A_NOTE:
        notes.append(
            f"the block does not start in {row.p_not_released:.0%} of the draws, since the slope "
            f"at its release is under the friction. {RELEASE_HINT}"
        )
    period, found = row.return_period_years, row.design
    if period is not None and not path.rate_known:
        notes.append(
            "nothing tells how often avalanches come down this path, so it has no design runout: "
            "give its records dates."
        )
    if found is not None and found.p_beyond > WORTH_A_NOTE:
        notes.append(
            f"part of what the {period:g}-year runout may be lies past the end of the profile. A "
            "longer one would tell how far."
        )
    if row.extrapolated:
        notes.append(
            f"{period:g} years are over twice the observed years, or past the ends of the table: "
            "an extrapolation."
        )
    if row.n_nonpositive_friction:
        notes.append(
            "some draws of friction were not over 0, as the normal distribution has it; they are "
            "left out. The lognormal one never does this."
        )
    if path.rising is not None and path.rising.share > WORTH_A_NOTE:
        notes.append(rising_words(path.rising))
    return tuple(notes)


def rising_words(rising: RisingFriction) -> str:
    """That larger avalanches may stop earlier, and how likely that is."""
    smallest, largest = (
        f"{float(f'{v:.2g}'):.0f}" for v in (rising.smallest_m3, rising.largest_m3)
    )
    return (
        f"in {rising.share:.0%} of the draws larger avalanches stop earlier: friction rises "
        f"with volume between the smallest and the largest record ({smallest} to {largest} m3)."
    )


def stale_words(model: str) -> str:
    """That a model does not know the records as they are now."""
    return f"the records have changed since {model} was calibrated."


def unconverged_words(model: str) -> str:
    """That a model's draws are not its posterior yet."""
    return f"the chains of {model} have not converged."
