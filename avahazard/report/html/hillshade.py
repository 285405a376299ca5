"""The ground lit from the north-west, as a small picture."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from numpy.typing import NDArray

AZIMUTH_DEG, ALTITUDE_DEG = 315.0, 45.0


def hillshade(elevation_m: NDArray[np.float32], cell_m: float) -> bytes:
    """PNG of elevations `[n_rows, n_columns]`, rows from north; clear where they are NaN."""
    from matplotlib.colors import LightSource  # noqa: PLC0415 (slow)
    from matplotlib.image import imsave  # noqa: PLC0415

    ground = elevation_m.astype(np.float64)
    light = LightSource(azdeg=AZIMUTH_DEG, altdeg=ALTITUDE_DEG)
    shade = light.hillshade(ground, dx=cell_m, dy=cell_m)
    picture = BytesIO()
    # Nothing of the day or of the machine: equal grounds make equal pictures.
    imsave(
        picture,
        np.round(0.35 + 0.65 * shade, 2),
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
        format="png",
        metadata={"Software": ""},
    )
    return picture.getvalue()
