"""Natural variability and uncertainty of the parameters, apart, and the chance to be reached."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avahazard.hazard.exceedance import (
    at_volume,
    middle_runout,
    natural_runouts,
    reach,
    runout_interval,
)
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.words import natural_words, parameters_words
from avahazard.results.hazard import ReachChance, RunoutInterval, YearlyChances


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """What a row has besides the bounds of its volume.

    `natural`: the runout of avalanches of the scenario's volume, all parameters at their middle.
    `parameters`: its median over the posterior of friction, and of the volume of the return
    period.
    """

    natural: RunoutInterval
    parameters: RunoutInterval


def uncertainties(path: PathHazard, scenario: Scenario) -> Uncertainties:
    """Part the uncertainty of a scenario's runout."""
    avalanches, period = path.avalanches, scenario.return_period
    volume = np.full(avalanches.n_parameters, np.log(scenario.any_volume_m3))
    fixed = uncertain = at_volume(avalanches, volume)
    if scenario.frequency is not None and period is not None:
        uncertain = at_volume(avalanches, scenario.frequency.draws.log_volume(1.0 / period))
    return Uncertainties(
        natural=runout_interval(avalanches, natural_runouts(fixed), natural_words(path)),
        parameters=runout_interval(
            avalanches,
            middle_runout(uncertain),
            parameters_words(path, return_period=period is not None),
        ),
    )


def annual_reach(path: PathHazard) -> ReachChance:
    """The annual chance of reaching places on the path."""
    found = reach(path.avalanches)
    low, middle, high = (tuple(chances) for chances in found.chance.T.tolist())
    return ReachChance(
        x_m=tuple(found.x.tolist()),
        elevation_m=tuple(found.elevation.tolist()),
        p_per_year=YearlyChances(low, middle, high),
    )
