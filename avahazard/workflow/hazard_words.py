"""What the intervals of `hazard` hold, in words."""

from __future__ import annotations

from avahazard.workflow.future_events import ignores_volume, path_release_zone, takes_event_columns
from avahazard.workflow.stored.model import StoredFit

PARAMETERS = "uncertainty of the calibrated parameters"


def interval_words(stored: StoredFit, path_id: str, *, return_period: bool) -> str:
    """What varies within the 5 to 95 % of a row."""
    unknown = _unknown_path(stored, path_id)
    parts = [*natural_parts(stored, path_id), PARAMETERS, *unknown]
    text = "90 % of avalanches; varying: " + ", ".join(parts)
    if ignores_volume(stored):
        return f"{text}; the volume does not matter to this model"
    if return_period:
        return f"{text}; fixed: the volume of the return period (its own error apart)"
    return f"{text}; fixed: the volume"


def natural_words(stored: StoredFit, path_id: str) -> str:
    """What varies in `natural`."""
    parts = ", ".join(natural_parts(stored, path_id))
    return f"90 % of avalanches; varying: {parts}; fixed: the volume, and all parameters"


def parameters_words(stored: StoredFit, path_id: str, *, return_period: bool) -> str:
    """What varies in `parameters`."""
    parts = [PARAMETERS, *_unknown_path(stored, path_id)]
    if return_period and not ignores_volume(stored):
        parts.append("error of the volume of the return period")
    return f"90 % of the posterior of the median runout; varying: {', '.join(parts)}"


def exceeded_words(stored: StoredFit, path_id: str) -> str:
    """What varies in `exceeded`, and what is mixed."""
    mixed = list(natural_parts(stored, path_id))
    parts = [PARAMETERS, *_unknown_path(stored, path_id), "error of the rate"]
    if not ignores_volume(stored):
        mixed.insert(0, "all volumes")
        parts.append("error of the frequency of volumes")
    return (
        "90 % of the posterior of the runout that a year exceeds with chance 1/T; "
        f"varying: {', '.join(parts)}; mixed: {', '.join(mixed)}"
    )


def natural_parts(stored: StoredFit, path_id: str) -> list[str]:
    """What varies from avalanche to avalanche, the volume apart."""
    parts = []
    if stored.model.sigma_m is not None:
        parts.append("scatter of the stop by sigma metres of elevation")
    else:
        tails = " (Student's t)" if stored.specification.tails == "student" else ""
        parts.append(
            f"natural scatter of friction ({stored.specification.distribution}{tails}) "
            "between avalanches"
        )
    if path_release_zone(stored.records, path_id) is not None:
        parts.append("the release, as in the records")
    if takes_event_columns(stored):
        parts.append("columns of the event, as in the records")
    return parts


def _unknown_path(stored: StoredFit, path_id: str) -> list[str]:
    by_path = stored.model.posterior.groups is not None
    if by_path and path_id not in stored.model.offsets:
        return ["the unknown friction of a path without records"]
    return []
