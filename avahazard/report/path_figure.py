"""A path in profile: its points, the regularised curve, releases and recorded stops."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np

from avahazard.arrays import Floats
from avahazard.physics.smooth_profile import SmoothProfile
from avahazard.records.path import Path, Profile
from avahazard.report.picture import picture

INTERVAL_90 = 1.645
"""Standard deviations from the middle to the 5 and 95 % of a normal distribution."""


def draw_path(
    file: FilePath,
    path: Path,
    profile: Profile,
    smooth: SmoothProfile,
    release_x: Floats,
    stop_x: Floats,
) -> None:
    """Draw the profile to `file`; `release_x` and `stop_x` (m), any number, lie on the curve.

    Raises:
        AvahazardError: `file` is not the name of a picture.
    """
    with picture(file) as axes:
        x = np.linspace(smooth.x_min, smooth.x_max, 1000)
        axes.plot(profile.x_m, profile.y_m, ".", color="0.6", markersize=3, label="points")
        axes.plot(x, smooth.height(x), color="black", linewidth=1, label=smooth.method)
        if smooth.posterior is not None:
            height, spread = smooth.height(x), INTERVAL_90 * smooth.posterior.sd(x)
            axes.fill_between(
                x,
                height - spread,
                height + spread,
                color="tab:orange",
                alpha=0.4,
                linewidth=0,
                label="ground, 5 to 95 %",
            )
        for place, mark, color, label in (
            (release_x, "v", "tab:blue", "releases"),
            (stop_x, "|", "tab:red", "recorded stops"),
        ):
            if len(place):
                height = smooth.height(place)
                axes.plot(place, height, mark, color=color, markersize=9, label=label)
        axes.set_xlabel("horizontal distance along the path x (m)")
        axes.set_ylabel("elevation (m)")
        axes.set_title(path.name or path.path_id)
        axes.legend()
