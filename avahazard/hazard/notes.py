"""What a reader of a row of `hazard` must know, and what its intervals hold, as notes."""

from __future__ import annotations

from avahazard.hazard.path_hazard import PathHazard
from avahazard.notes import Note
from avahazard.results.hazard import HazardRow

WORTH_A_NOTE = 0.05
"""Share of draws from which something is said of them."""


def row_notes(path: PathHazard, row: HazardRow) -> tuple[Note, ...]:
    """The notes on one row, without the name of its path."""
    notes = []
    if row.p_not_released > WORTH_A_NOTE:
        notes.append(Note("not_started", share=row.p_not_released, hint=Note("check_release")))
    period, found = row.return_period_years, row.design
    if period is not None and not path.rate_known:
        notes.append(Note("no_rate"))
    if found is not None and found.p_beyond > WORTH_A_NOTE:
        wholly = found.p_beyond > 1.0 - WORTH_A_NOTE
        notes.append(Note("all_beyond" if wholly else "part_beyond", period=period))
    if row.extrapolated:
        notes.append(Note("extrapolated", period=period))
    if row.n_nonpositive_friction:
        notes.append(Note("not_positive"))
    if path.rising is not None and path.rising.share > WORTH_A_NOTE:
        smallest, largest = (
            float(f"{v:.2g}") for v in (path.rising.smallest_m3, path.rising.largest_m3)
        )
        share = path.rising.share
        notes.append(Note("rising_friction", share=share, smallest=smallest, largest=largest))
    return tuple(notes)


def row_interval(path: PathHazard, *, return_period: bool) -> Note:
    """What varies within the 5 to 95 % of a row."""
    parts = [*natural_parts(path), Note("of_parameters"), *_unknown_path(path)]
    if not path.varying.volume:
        return Note("interval_any", parts=parts)
    return Note("interval_period" if return_period else "interval_volume", parts=parts)


def natural_interval(path: PathHazard) -> Note:
    """What varies in `natural`."""
    return Note("interval_nature", parts=natural_parts(path))


def parameters_interval(path: PathHazard, *, return_period: bool) -> Note:
    """What varies in `parameters`."""
    parts = [Note("of_parameters"), *_unknown_path(path)]
    if return_period and path.varying.volume:
        parts.append(Note("of_volume_error"))
    return Note("interval_parameters", parts=parts)


def design_interval(path: PathHazard) -> Note:
    """What varies in `design`, and what is mixed."""
    mixed = natural_parts(path)
    parts = [Note("of_parameters"), *_unknown_path(path), Note("of_rate_error")]
    if path.varying.volume:
        mixed.insert(0, Note("of_all_volumes"))
        parts.append(Note("of_frequency_error"))
    return Note("interval_design", parts=parts, mixed=mixed)


def natural_parts(path: PathHazard) -> list[Note]:
    """What varies from avalanche to avalanche, the volume apart."""
    in_log = path.avalanches.in_log
    if path.avalanches.sigma_m is not None:
        family = "of_elevation"
    elif path.avalanches.student:
        family = "of_lognormal_student" if in_log else "of_normal_student"
    else:
        family = "of_lognormal" if in_log else "of_normal"
    parts = [Note(family)]
    if path.varying.release:
        parts.append(Note("of_release"))
    if path.varying.columns:
        parts.append(Note("of_columns"))
    return parts


def _unknown_path(path: PathHazard) -> list[Note]:
    return [Note("of_unknown_path")] if path.offset_unknown else []
