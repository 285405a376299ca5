"""The design runout of a path: what its avalanches exceed once in T years."""

from __future__ import annotations

import numpy as np

from avahazard.arrays import Floats
from avahazard.hazard.exceedance import exceeded_runout
from avahazard.hazard.path_hazard import PathHazard
from avahazard.hazard.runout_bounds import QUANTILES, order_statistics
from avahazard.hazard.words import design_words
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.results.hazard import Design, PlaceQuantiles


def design(path: PathHazard, return_period_years: float) -> Design | None:
    """The design runout of a return period over 1 year; None where the path's rate is not known.

    Every return period takes the same draws of the parameters, and in each draw the runout rises
    with it (`avalanches.exceeded`): so do all quantiles, whatever friction does with volume.
    """
    if not path.rate_known:
        return None
    return design_of(path, exceeded_runout(path.avalanches, return_period_years))


def design_of(path: PathHazard, x: Floats) -> Design:
    """The same of the runouts x (m) `[n_parameters]` of a return period, inf past the end."""
    places = place_quantiles(x)
    middle, recorded = places.q50, path.recorded
    return Design(
        runout_x_m=places,
        runout_elevation_m=elevation_quantiles(path.avalanches.site.smooth, x),
        p_beyond=float(np.mean(np.isinf(x))),
        point=None if middle is None else recorded.point(middle),
        farthest_record=recorded.farthest(),
        records_beyond=None if middle is None else recorded.beyond(middle),
        n_records=len(recorded.x),
        interval=design_words(path),
    )


def place_quantiles(x: Floats) -> PlaceQuantiles:
    """5, 50 and 95 % of places x (m) `[n]`, inf beyond the profile; each is one of them."""
    found = order_statistics(x, QUANTILES)
    return PlaceQuantiles(*(float(q) if np.isfinite(q) else None for q in found))


def elevation_quantiles(smooth: SmoothProfile, x: Floats) -> PlaceQuantiles:
    """5, 50 and 95 % of the elevations at places x (m) `[n]`, inf below all others.

    By depth, so that on falling ground each is the elevation at the mirrored quantile of x.
    """
    inside = np.isfinite(x)
    depth = np.where(inside, -smooth.height(np.where(inside, x, smooth.x_max)), np.inf)
    shallow, middle, deep = (
        -float(q) if np.isfinite(q) else None for q in order_statistics(depth, QUANTILES)
    )
    return PlaceQuantiles(q05=deep, q50=middle, q95=shallow)
