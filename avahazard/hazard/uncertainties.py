"""Natural variability and uncertainty of the parameters, apart, and the runout exceeded in T."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from avahazard.hazard.exceedance import (
    RunoutSpread,
    at_volume,
    exceeded_runout,
    middle_runout,
    natural_runouts,
    reach,
    runout_spread,
)
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.scenario import Scenario
from avahazard.hazard.words import exceeded_words, natural_words, parameters_words


def uncertainties(path: PathHazard, scenario: Scenario) -> dict[str, Any]:
    """What a row has besides its bounds.

    `natural`: the runout of avalanches of the scenario's volume, all parameters at their middle.
    `parameters`: its median over the posterior of friction, and of the volume of the return
    period. `exceeded`: the runout that a year exceeds with chance 1/T, all volumes mixed at the
    path's rate.
    """
    avalanches, period = path.avalanches, scenario.return_period
    volume = np.full(avalanches.n_parameters, np.log(scenario.any_volume_m3))
    fixed = uncertain = at_volume(avalanches, volume)
    if scenario.frequency is not None and period is not None:
        uncertain = at_volume(avalanches, scenario.frequency.draws.log_volume(1.0 / period))
    result = {
        "natural": {
            **_lengths(runout_spread(avalanches, natural_runouts(fixed))),
            "interval": natural_words(path),
        },
        "parameters": {
            **_lengths(runout_spread(avalanches, middle_runout(uncertain))),
            "interval": parameters_words(path, return_period=period is not None),
        },
    }
    if path.rate_known and period is not None:
        result["exceeded"] = {
            **_lengths(runout_spread(avalanches, exceeded_runout(avalanches, period))),
            "interval": exceeded_words(path),
        }
    return result


def annual_reach(path: PathHazard) -> dict[str, Any]:
    """The annual chance of reaching places on the path."""
    found = reach(path.avalanches)
    low, middle, high = found.chance.T
    return {
        "x_m": found.x.tolist(),
        "elevation_m": found.elevation.tolist(),
        "p_per_year": {"q05": low.tolist(), "q50": middle.tolist(), "q95": high.tolist()},
    }


def _lengths(found: RunoutSpread) -> dict[str, Any]:
    return {"runout_x_m": asdict(found.x), "runout_elevation_m": asdict(found.elevation)}
