"""What the intervals of `hazard` hold, in words."""

from __future__ import annotations

from avahazard.hazard.path_hazard import PathHazard

PARAMETERS = "uncertainty of the calibrated parameters"


def interval_words(path: PathHazard, *, return_period: bool) -> str:
    """What varies within the 5 to 95 % of a row."""
    unknown = _unknown_path(path)
    parts = [*natural_parts(path), PARAMETERS, *unknown]
    text = "90 % of avalanches; varying: " + ", ".join(parts)
    if not path.varying.volume:
        return f"{text}; the volume does not matter to this model"
    if return_period:
        return f"{text}; fixed: the volume of the return period (its own error apart)"
    return f"{text}; fixed: the volume"


def natural_words(path: PathHazard) -> str:
    """What varies in `natural`."""
    parts = ", ".join(natural_parts(path))
    return f"90 % of avalanches; varying: {parts}; fixed: the volume, and all parameters"


def parameters_words(path: PathHazard, *, return_period: bool) -> str:
    """What varies in `parameters`."""
    parts = [PARAMETERS, *_unknown_path(path)]
    if return_period and path.varying.volume:
        parts.append("error of the volume of the return period")
    return f"90 % of the posterior of the median runout; varying: {', '.join(parts)}"


def design_words(path: PathHazard) -> str:
    """What varies in `design`, and what is mixed."""
    mixed = list(natural_parts(path))
    parts = [PARAMETERS, *_unknown_path(path), "error of the rate"]
    if path.varying.volume:
        mixed.insert(0, "all volumes")
        parts.append("error of the frequency of volumes")
    return (
        "90 % of what the runout exceeded once in T years may be (chance 1/T a year); "
        f"varying: {', '.join(parts)}; mixed: {', '.join(mixed)}"
    )


def natural_parts(path: PathHazard) -> list[str]:
    """What varies from avalanche to avalanche, the volume apart."""
    parts = []
    if path.avalanches.sigma_m is not None:
        parts.append("scatter of the stop by sigma metres of elevation")
    else:
        family = "lognormal" if path.avalanches.in_log else "normal"
        tails = " (Student's t)" if path.avalanches.student else ""
        parts.append(f"natural scatter of friction ({family}{tails}) between avalanches")
    if path.varying.release:
        parts.append("the release, as in the records")
    if path.varying.columns:
        parts.append("columns of the event, as in the records")
    return parts


def _unknown_path(path: PathHazard) -> list[str]:
    return ["the unknown friction of a path without records"] if path.offset_unknown else []
