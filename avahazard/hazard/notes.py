"""What a reader of a row of `hazard` must know, in sentences that go with it everywhere."""

from __future__ import annotations

from avahazard.hazard.path_hazard import PathHazard, RisingFriction
from avahazard.message import message
from avahazard.results.hazard import HazardRow

WORTH_A_NOTE = 0.05
"""Share of draws from which something is said of them."""
RELEASE_HINT = message(
    "Real ones start: check where the releases stand on the profile (release_elevation_m of the "
    "events, else of the path, else its top), and that the volume is like those on record."
)
"""What may be wrong where blocks do not start."""
NOT_STARTED = message(
    "the block does not start in {share} of the draws, since the slope at its release is under "
    "the friction. {hint}"
)
NO_RATE = message(
    "nothing tells how often avalanches come down this path, so it has no design runout: give its "
    "records dates."
)
PAST_THE_END = message(
    "part of what the {period}-year runout may be lies past the end of the profile. A longer one "
    "would tell how far."
)
WHOLLY_PAST_THE_END = message(
    "the {period}-year runout lies past the end of the profile, and nothing here tells how far: "
    "import a profile that reaches further."
)
EXTRAPOLATED = message(
    "{period} years are over twice the observed years, or past the ends of the table: an "
    "extrapolation."
)
NOT_POSITIVE = message(
    "some draws of friction were not over 0, as the normal distribution has it; they are left "
    "out. The lognormal one never does this."
)
RISING = message(
    "in {share} of the draws larger avalanches stop earlier: friction rises with volume between "
    "the smallest and the largest record ({smallest} to {largest} m3)."
)
STALE = message("the records have changed since {model} was calibrated.")
UNCONVERGED = message("the chains of {model} have not converged.")


def row_notes(path: PathHazard, row: HazardRow) -> tuple[str, ...]:
    """The notes on one row, without the name of its path."""
    notes = []
    if row.p_not_released > WORTH_A_NOTE:
        notes.append(NOT_STARTED.format(share=f"{row.p_not_released:.0%}", hint=RELEASE_HINT))
    period, found = row.return_period_years, row.design
    if period is not None and not path.rate_known:
        notes.append(NO_RATE)
    if found is not None and found.p_beyond > WORTH_A_NOTE:
        past = WHOLLY_PAST_THE_END if found.p_beyond > 1.0 - WORTH_A_NOTE else PAST_THE_END
        notes.append(past.format(period=f"{period:g}"))
    if row.extrapolated:
        notes.append(EXTRAPOLATED.format(period=f"{period:g}"))
    if row.n_nonpositive_friction:
        notes.append(NOT_POSITIVE)
    if path.rising is not None and path.rising.share > WORTH_A_NOTE:
        notes.append(rising_words(path.rising))
    return tuple(notes)


def rising_words(rising: RisingFriction) -> str:
    """That larger avalanches may stop earlier, and how likely that is."""
    smallest, largest = (
        f"{float(f'{v:.2g}'):.0f}" for v in (rising.smallest_m3, rising.largest_m3)
    )
    return RISING.format(share=f"{rising.share:.0%}", smallest=smallest, largest=largest)


def stale_words(model: str) -> str:
    """That a model does not know the records as they are now."""
    return STALE.format(model=model)


def unconverged_words(model: str) -> str:
    """That a model's draws are not its posterior yet."""
    return UNCONVERGED.format(model=model)
