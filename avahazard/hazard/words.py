"""What the intervals of `hazard` hold, in words."""

from __future__ import annotations

from avahazard.hazard.path_hazard import PathHazard
from avahazard.message import message

PARAMETERS = message("uncertainty of the calibrated parameters")
UNKNOWN_PATH = message("the unknown friction of a path without records")
ANY = message("90 % of avalanches; varying: {parts}; the volume does not matter to this model")
OF_PERIOD = message(
    "90 % of avalanches; varying: {parts}; fixed: the volume of the return period (its own error "
    "apart)"
)
OF_VOLUME = message("90 % of avalanches; varying: {parts}; fixed: the volume")
BY_NATURE = message("90 % of avalanches; varying: {parts}; fixed: the volume, and all parameters")
BY_PARAMETERS = message("90 % of the posterior of the median runout; varying: {parts}")
VOLUME_ERROR = message("error of the volume of the return period")
RATE_ERROR = message("error of the rate")
ALL_VOLUMES = message("all volumes")
FREQUENCY_ERROR = message("error of the frequency of volumes")
EXCEEDED = message(
    "90 % of what the runout exceeded once in T years may be (chance 1/T a year); varying: "
    "{parts}; mixed: {mixed}"
)
OF_ELEVATION = message("scatter of the stop by sigma metres of elevation")
OF_FRICTION = message("natural scatter of friction ({family}) between avalanches")
HEAVY = {
    "lognormal": message("lognormal (Student's t)"),
    "normal": message("normal (Student's t)"),
}
LIGHT = {"lognormal": message("lognormal"), "normal": message("normal")}
RELEASE = message("the release, as in the records")
COLUMNS = message("columns of the event, as in the records")


def interval_words(path: PathHazard, *, return_period: bool) -> str:
    """What varies within the 5 to 95 % of a row."""
    unknown = _unknown_path(path)
    parts = [*natural_parts(path), PARAMETERS, *unknown]
    text = OF_PERIOD if return_period else OF_VOLUME
    return (text if path.varying.volume else ANY).format(parts=", ".join(parts))


def natural_words(path: PathHazard) -> str:
    """What varies in `natural`."""
    return BY_NATURE.format(parts=", ".join(natural_parts(path)))


def parameters_words(path: PathHazard, *, return_period: bool) -> str:
    """What varies in `parameters`."""
    parts = [PARAMETERS, *_unknown_path(path)]
    if return_period and path.varying.volume:
        parts.append(VOLUME_ERROR)
    return BY_PARAMETERS.format(parts=", ".join(parts))


def design_words(path: PathHazard) -> str:
    """What varies in `design`, and what is mixed."""
    mixed = list(natural_parts(path))
    parts = [PARAMETERS, *_unknown_path(path), RATE_ERROR]
    if path.varying.volume:
        mixed.insert(0, ALL_VOLUMES)
        parts.append(FREQUENCY_ERROR)
    return EXCEEDED.format(parts=", ".join(parts), mixed=", ".join(mixed))


def natural_parts(path: PathHazard) -> list[str]:
    """What varies from avalanche to avalanche, the volume apart."""
    parts = []
    if path.avalanches.sigma_m is not None:
        parts.append(OF_ELEVATION)
    else:
        family = "lognormal" if path.avalanches.in_log else "normal"
        families = HEAVY if path.avalanches.student else LIGHT
        parts.append(OF_FRICTION.format(family=families[family]))
    if path.varying.release:
        parts.append(RELEASE)
    if path.varying.columns:
        parts.append(COLUMNS)
    return parts


def _unknown_path(path: PathHazard) -> list[str]:
    return [UNKNOWN_PATH] if path.offset_unknown else []
