"""The ground lit from the north-west, as a small picture."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from numpy.typing import NDArray

TO_LIGHT = np.array([-0.5, 0.5, np.sqrt(0.5)])
"""East, north, up: from the north-west, 45° high."""
DARKEST = 0.35


def hillshade(elevation_m: NDArray[np.float32], cell_m: float) -> bytes:
    """PNG of elevations `[n_rows, n_columns]`, rows from north; clear where they are NaN.

    Grey is the cosine of the angle between the normal of the ground and the light (Lambert).
    """
    from matplotlib.image import imsave  # noqa: PLC0415 (slow)

    ground = elevation_m.astype(np.float64)
    southward, eastward = np.gradient(ground, cell_m)
    normal = np.stack([-eastward, southward, np.ones_like(ground)])
    light = np.tensordot(TO_LIGHT, normal, 1) / np.linalg.norm(normal, axis=0)
    shade = DARKEST + (1.0 - DARKEST) * np.clip(light, 0.0, 1.0)
    shade[np.isnan(ground)] = np.nan
    picture = BytesIO()
    # Nothing of the day or of the machine: equal grounds make equal pictures.
    imsave(
        picture,
        np.round(shade, 2),
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
        format="png",
        metadata={"Software": ""},
    )
    return picture.getvalue()
