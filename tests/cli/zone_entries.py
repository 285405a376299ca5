"""A made-up entry of `zones`."""

from __future__ import annotations

from typing import Any


def entry(beyond: bool = False) -> dict[str, Any]:
    """One path, 81 places, two return periods; red is empty."""
    zone = {"color": "#000000", "from_x_m": 100.0, "to_x_q05_m": 700.0}
    places = [
        {
            "x_m": 100.0 + 10.0 * i,
            "elevation_m": 2000.0 - 5.0 * i,
            "p_reach_per_year": 0.0123,
            "by_return_period": [
                {
                    "return_period_years": period,
                    "extrapolated": period == 300.0,
                    "speed_m_s": {"q05": 10.0 + i, "q50": 20.0 + i, "q95": 30.0 + i},
                    "pressure_kpa": {"q05": 30.0, "q50": 120.0, "q95": 270.0},
                }
                for period in (30.0, 300.0)
            ],
        }
        for i in range(81)
    ]
    return {
        "path_id": "P01",
        "limits": "swiss",
        "density_kg_m3": {"mean": 300.0, "sd": 50.0},
        "interval": "what a year exceeds",
        "places": places,
        "zones": [
            {
                **zone,
                "zone": "red",
                "to_x_m": 100.0,
                "to_x_q95_m": 200.0,
                "beyond": False,
                "extrapolated": False,
            },
            {
                **zone,
                "zone": "blue",
                "to_x_m": 900.0,
                "to_x_q95_m": None,
                "beyond": beyond,
                "extrapolated": True,
            },
        ],
    }
